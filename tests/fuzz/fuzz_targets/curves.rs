#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("curves"),
    |data: &[u8]| crepuscular_fuzz::curves::run(data)
);
