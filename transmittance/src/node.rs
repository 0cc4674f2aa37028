//! Nodes of a transmittance curve, and where a depth lies among them.
//!
//! Nodes are ordered by depth. At most two share a depth: the value just
//! before a surface and the value behind it. The first has the value of a
//! clear ray, so that what lies in front of it is 1; what lies behind the last
//! has the last one's value.

/// A point of the curve, and what is known about the stretch up to the next.
///
/// Values are those of the curve's lookup: transmittances (linear) or optical
/// depths (exponential). On the stretch that begins here the exact curve lies
/// between `interpolated − below` and `interpolated + above` in the same
/// quantity, roundings of the values aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<const C: usize> {
    pub(crate) depth: f32,
    pub(crate) value: [f32; C],
    pub(crate) above: [f32; C],
    pub(crate) below: [f32; C],
}

impl<const C: usize> Node<C> {
    /// The value of unused entries of a curve.
    pub(crate) const UNUSED: Self = Self {
        depth: 0.0,
        value: [0.0; C],
        above: [0.0; C],
        below: [0.0; C],
    };
}

/// Number of the first `len` depths that are in front of `depth`; 0 for NaN.
///
/// Comparisons are summed without branches: depths come in any order, and a
/// mispredicted branch costs as much as a dozen comparisons. Many depths take two levels:
/// every fourth depth tells the group, whose own depths tell the rest.
#[inline]
pub(crate) fn count_in_front(depths: impl Fn(usize) -> f32, len: usize, depth: f32) -> usize {
    /// Up to this number, comparing all is as fast.
    const FEW: usize = 16;
    const GROUP: usize = 4;
    if len <= FEW {
        let in_front = |index| u32::from(depths(index) < depth);
        return (0..len).map(in_front).sum::<u32>() as usize;
    }
    let groups = (0..len / GROUP)
        .filter(|group| depths(group * GROUP + GROUP - 1) < depth)
        .count();
    let start = groups * GROUP;
    start
        + (start..len.min(start + GROUP))
            .filter(|&index| depths(index) < depth)
            .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_levels_find_what_one_level_finds() {
        let depths = [
            -4.0_f32, -3.0, -2.0, -2.0, 0.0, 0.5, 1.0, 2.0, 2.0, 3.0, 5.0, 8.0, 8.0, 9.0, 9.5,
            11.0, 12.0, 12.5,
        ];
        for len in 0..=depths.len() {
            for depth in [
                -5.0, -2.0, 0.0, 1.0, 1.5, 2.0, 2.5, 8.0, 8.5, 9.2, 11.0, 12.0, 13.0,
            ] {
                let plain = depths[..len].iter().filter(|&&d| d < depth).count();
                let found = count_in_front(|index| depths[index], len, depth);
                assert_eq!(found, plain, "{depth} in {len}");
            }
            assert_eq!(count_in_front(|index| depths[index], len, f32::NAN), 0);
        }
    }
}
