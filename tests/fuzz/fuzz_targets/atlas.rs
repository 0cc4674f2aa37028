#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("atlas"),
    |data: &[u8]| crepuscular_fuzz::atlas::run(data)
);
