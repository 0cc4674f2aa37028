//! Numbers as people read them.

/// `value` with three significant digits, without an exponent between 1e-4 and
/// 1e6.
pub(crate) fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let decimals = (2.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// A duration in the unit that suits it: `12.3 ms`.
pub(crate) fn seconds(value: f64) -> String {
    if value == 0.0 {
        "0".into()
    } else if value < 0.9995e-6 {
        format!("{} ns", significant(value * 1e9))
    } else if value < 0.9995e-3 {
        format!("{} µs", significant(value * 1e6))
    } else if value < 0.9995 {
        format!("{} ms", significant(value * 1e3))
    } else {
        format!("{} s", significant(value))
    }
}

/// An amount of memory in binary units: `24.0 MiB`.
pub(crate) fn bytes(value: u64) -> String {
    const UNITS: [&str; 4] = ["KiB", "MiB", "GiB", "TiB"];
    if value < 1024 {
        return format!("{value} B");
    }
    let mut scaled = value as f64 / 1024.0;
    let mut unit = 0;
    while scaled >= 1023.95 && unit + 1 < UNITS.len() {
        scaled /= 1024.0;
        unit += 1;
    }
    format!("{scaled:.1} {}", UNITS[unit])
}

/// An error of the airlight: a percentage of the reference's mean radiance, or
/// a plain radiance if that mean is 0.
pub(crate) fn error(value: f64, absolute: bool) -> String {
    if !value.is_finite() {
        "not finite".into()
    } else if absolute {
        significant(value)
    } else {
        format!("{} %", significant(value * 100.0))
    }
}

/// `3 lights`, `1 light`.
pub(crate) fn count(number: usize, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {what}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (12.345, "12.3"),
            (999.9, "1000"),
            (0.001_234, "0.00123"),
            (123_456.0, "123456"),
            (1.24e-9, "1.2e-9"),
            (-0.5, "-0.5"),
            (1e7, "1e7"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn units_follow_the_size() {
        assert_eq!(seconds(0.0123), "12.3 ms");
        assert_eq!(seconds(2.5e-6), "2.5 µs");
        assert_eq!(seconds(0.9999), "1 s");
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(24 << 20), "24.0 MiB");
        assert_eq!(bytes(u64::MAX), "16777216.0 TiB");
        assert_eq!(error(0.0123, false), "1.23 %");
        assert_eq!(error(0.0123, true), "0.0123");
        assert_eq!(error(f64::NAN, false), "not finite");
        assert_eq!(count(1, "light"), "1 light");
        assert_eq!(count(0, "light"), "0 lights");
    }
}
