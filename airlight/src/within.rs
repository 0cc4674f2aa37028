//! Numbers from users.

/// The number of an interval that is nearest to `value`; the lowest for NaN.
pub(crate) fn within<T: PartialOrd>(value: T, low: T, high: T) -> T {
    if value >= high {
        high
    } else if value > low {
        value
    } else {
        low
    }
}
