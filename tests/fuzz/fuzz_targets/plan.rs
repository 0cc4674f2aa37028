#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("plan"),
    |data: &[u8]| crepuscular_fuzz::plan::run(data)
);
