#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("scene"),
    |data: &[u8]| crepuscular_fuzz::scene::run(data)
);
