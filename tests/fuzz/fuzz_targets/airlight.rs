#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("airlight"),
    |data: &[u8]| crepuscular_fuzz::airlight::run(data)
);
