//! One seed and one loop for every property.
//!
//! Properties are tried on the same inputs on every run and every machine, so
//! that a failure can be repeated. Two environment variables change that:
//!
//! * `PROPERTY_SEED=fresh` draws a seed from the clock, `PROPERTY_SEED=1234`
//!   takes that one. Either is printed, and the test harness shows what a test
//!   that failed has printed.
//! * `PROPTEST_CASES` overrides the number of inputs, for longer hunts.
//!
//! Properties in `proptest!` blocks take their configuration from [`cases`].
//! Inputs at which they failed are kept in files beside their source
//! (`*.proptest-regressions`, `proptest-regressions/`) and tried first from
//! then on; commit these files with the fix.

use std::fmt::Debug;
use std::time::{SystemTime, UNIX_EPOCH};

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestCaseResult, TestRng, TestRunner};

/// The seed of properties in `proptest!` blocks, where none is asked for.
const SEED: u64 = 0x6372_6570_7573_6375;

/// The configuration of properties in a `proptest!` block that are tried on
/// `cases` inputs:
///
/// ```
/// use proptest::prelude::*;
/// use reference::property::cases;
///
/// proptest! {
///     #![proptest_config(cases(100))]
///
///     // A test has `#[test]` here.
///     fn halves_make_a_whole(x in 0.0_f32..1e30) {
///         prop_assert_eq!(0.5 * x + 0.5 * x, x);
///     }
/// }
/// halves_make_a_whole();
/// ```
///
/// # Panics
/// If `PROPERTY_SEED` is neither a number nor `fresh`, or `PROPTEST_CASES` is no
/// number.
pub fn cases(cases: u32) -> Config {
    Config {
        cases: case_count(cases),
        rng_seed: RngSeed::Fixed(asked_seed().unwrap_or(SEED)),
        ..Config::default()
    }
}

/// Tries a property on `cases` values of `strategy` and panics with the
/// simplest one that fails.
///
/// # Panics
/// If the property fails, and as [`cases`] does.
pub fn holds_for<S>(cases: u32, strategy: S, property: impl Fn(S::Value) -> TestCaseResult)
where
    S: Strategy,
    S::Value: Debug,
{
    let config = Config {
        cases: case_count(cases),
        failure_persistence: None,
        ..Config::default()
    };
    let rng = match asked_seed() {
        None => TestRng::deterministic_rng(RngAlgorithm::ChaCha),
        Some(seed) => {
            let bytes: Vec<u8> = seed.to_le_bytes().repeat(4);
            TestRng::from_seed(RngAlgorithm::ChaCha, &bytes)
        }
    };
    let mut runner = TestRunner::new_with_rng(config, rng);
    if let Err(failure) = runner.run(&strategy, property) {
        panic!("{failure}");
    }
}

fn case_count(otherwise: u32) -> u32 {
    match std::env::var("PROPTEST_CASES") {
        Ok(value) => value.parse().expect("PROPTEST_CASES is a number"),
        Err(_) => otherwise,
    }
}

/// The seed that `PROPERTY_SEED` asks for, if it does.
fn asked_seed() -> Option<u64> {
    let value = std::env::var("PROPERTY_SEED").ok()?;
    let seed = match value.as_str() {
        "fresh" => SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_nanos() as u64),
        number => number
            .parse()
            .expect("PROPERTY_SEED is a number or `fresh`"),
    };
    println!("repeat this run with PROPERTY_SEED={seed}");
    Some(seed)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    fn inputs() -> Vec<u32> {
        let seen = RefCell::new(Vec::new());
        holds_for(50, 0_u32..1000, |value| {
            seen.borrow_mut().push(value);
            Ok(())
        });
        seen.into_inner()
    }

    #[test]
    fn two_runs_see_the_same_inputs() {
        if std::env::var("PROPERTY_SEED").as_deref() != Ok("fresh") {
            assert_eq!(inputs(), inputs());
            assert_eq!(cases(7).rng_seed, cases(9).rng_seed);
        }
        let all = inputs();
        assert!(all.iter().any(|value| *value != all[0]));
    }

    #[test]
    #[should_panic(expected = "minimal failing input")]
    fn a_property_that_fails_names_its_simplest_input() {
        holds_for(200, 0_u32..1000, |value| {
            if value < 100 {
                Ok(())
            } else {
                Err(proptest::test_runner::TestCaseError::fail("too large"))
            }
        });
    }
}
