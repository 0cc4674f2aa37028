#![no_main]

libfuzzer_sys::fuzz_target!(
    init: crepuscular_fuzz::write_seeds("epipolar"),
    |data: &[u8]| crepuscular_fuzz::epipolar::run(data)
);
