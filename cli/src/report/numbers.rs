//! Numbers of tables and axes as people read them.

use crate::compare::study::{Unit, Value};
use crate::format::{bytes, error, seconds, significant};

/// A number in its unit; `not finite` if it is none.
pub(super) fn written(number: f64, unit: Unit) -> String {
    if !number.is_finite() {
        return "not finite".into();
    }
    match unit {
        Unit::Number => significant(number),
        Unit::Below(end) if number >= end => format!("≥ {}", significant(end)),
        Unit::Below(_) => significant(number),
        Unit::Share => error(number, false),
        Unit::Seconds => seconds(number),
        Unit::Bytes => bytes(number.round() as u64),
        Unit::With(suffix) => format!("{}{suffix}", significant(number)),
    }
}

/// The value of a cell in the unit of its column. Counts keep all their digits.
pub(super) fn value(value: &Value, unit: Unit) -> String {
    match (value, unit) {
        (Value::Text(text), _) => text.clone(),
        (Value::Count(count), Unit::Bytes) => bytes(*count),
        (Value::Count(count), Unit::With(suffix)) => format!("{count}{suffix}"),
        (Value::Count(count), _) => count.to_string(),
        (Value::Number(number), unit) => written(*number, unit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_writes_numbers_and_none_writes_what_is_not_finite() {
        for (unit, text) in [
            (Unit::Number, "0.123"),
            (Unit::Below(10.0), "0.123"),
            (Unit::Below(0.1), "≥ 0.1"),
            (Unit::Share, "12.3 %"),
            (Unit::Seconds, "123 ms"),
            (Unit::Bytes, "0 B"),
            (Unit::With(" m"), "0.123 m"),
        ] {
            assert_eq!(written(0.123, unit), text);
            for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert_eq!(written(odd, unit), "not finite");
            }
        }
    }

    #[test]
    fn counts_keep_their_digits() {
        assert_eq!(value(&Value::Count(123_456_789), Unit::Number), "123456789");
        assert_eq!(value(&Value::Count(2048), Unit::With("³")), "2048³");
        assert_eq!(value(&Value::Count(2048), Unit::Bytes), "2.0 KiB");
    }
}
