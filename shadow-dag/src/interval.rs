//! The depths at which a column of voxels may turn from lit to shadowed.

/// The slices at which a texel may turn from lit to shadowed.
///
/// A voxel of slice `z` is lit if `z < enter`, shadowed if `z ≥ exit` and
/// free in between: it is inside of a solid, where no point is ever shaded.
/// Always `enter ≤ exit` for one texel. The interval of several texels is the
/// [intersection](Self::meet) of theirs, and can be empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Interval {
    pub(crate) enter: u32,
    pub(crate) exit: u32,
}

impl Interval {
    /// The depths that suit both; empty (`enter > exit`) if there are none.
    pub(crate) fn meet(self, other: Self) -> Self {
        Self {
            enter: self.enter.max(other.enter),
            exit: self.exit.min(other.exit),
        }
    }

    pub(crate) fn is_empty(self) -> bool {
        self.enter > self.exit
    }

    /// The depth in a non-empty interval that is a multiple of the highest
    /// power of two: the one at which the fewest levels have to split.
    /// `side`, the end of the grid, counts as the highest of all.
    pub(crate) fn most_aligned(self, side: u32) -> u32 {
        debug_assert!(!self.is_empty(), "{self:?}");
        if self.exit >= side {
            return side;
        }
        if self.enter == 0 {
            return 0;
        }
        // All bits of `exit` below the highest one in which `enter − 1` and `exit` differ can be
        // cleared without falling below `enter`.
        let shift = 31 - ((self.enter - 1) ^ self.exit).leading_zeros();
        self.exit >> shift << shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_aligned_depth_is_found_by_trying_all() {
        let side = 64;
        for enter in 0..=side {
            for exit in enter..=side {
                let found = Interval { enter, exit }.most_aligned(side);
                assert!((enter..=exit).contains(&found));
                let rank = |z: u32| {
                    if z == side { 100 } else { z.trailing_zeros() }
                };
                let best = (enter..=exit).map(rank).max();
                assert_eq!(Some(rank(found)), best, "[{enter}, {exit}] gave {found}");
            }
        }
    }
}
