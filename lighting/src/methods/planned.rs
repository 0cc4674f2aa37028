//! Methods for lights that a [plan](crate::plan) calls unshadowed.

use super::evaluators::{Gauss, Midpoints, Tolerances};
use super::unshadowed::NAME as NOTHING;
use super::{Entry, Evaluators, Registry, Role};

impl Registry {
    /// The method and quality that gather unshadowed lights in place of `entry` at `quality`;
    /// `None` if the method should gather them itself.
    ///
    /// Nothing blocks these lights, so their airlight is that of whole rays.
    ///
    /// * If the method is a product whose visibility has no quality, such as the exact one,
    ///   evaluator and quality stay the same: so does the picture, bit for bit.
    /// * If the method is another product, an evaluator that gives light a look of its own is
    ///   kept. Sums over nodes or single samples are replaced: whole rays are integrated to a
    ///   relative error of 1e-4. So are methods that are no product. A table could be looked up
    ///   faster, but takes longer to make than the rays of a picture take.
    pub fn unshadowed(&self, entry: &Entry, quality: u32) -> Option<(Entry, u32)> {
        let (evaluator, quality) = match entry.halves() {
            Some([(NOTHING, _), _]) => return None,
            None if entry.about().role == Role::Unshadowed => return None,
            Some([(_, None), (evaluator, _)]) => (evaluator, Some(quality)),
            Some([_, (evaluator, _)])
                if ![Midpoints::ABOUT.name, Gauss::ABOUT.name].contains(&evaluator) =>
            {
                (evaluator, None)
            }
            _ => (Tolerances::ABOUT.name, None),
        };
        let found = self.pair(NOTHING, evaluator, None)?;
        let quality = quality.unwrap_or_else(|| found.about().usual);
        Some((found, quality))
    }
}
