#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("depths"),
    |data: &[u8]| crepuscular_fuzz::depths::run(data)
);
