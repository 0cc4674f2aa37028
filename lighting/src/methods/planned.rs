//! Methods for lights that a [plan](crate::plan) calls unshadowed.

use super::evaluators::{Gauss, Midpoints, Tolerances};
use super::unshadowed::NAME as NOTHING;
use super::{Entry, Evaluators, Registry, Role};

impl Registry {
    /// What gathers unshadowed lights instead of a method at a quality, and the quality of its
    /// own; `None` if the method should do that itself.
    ///
    /// Nothing is in the way of these lights, so that their airlight is that of whole rays.
    ///
    /// * A product of a visibility without a quality, such as the exact one, keeps its
    ///   evaluator and quality: the picture is the same, bit for bit.
    /// * Another product keeps an evaluator by which its light has a look of its own. In
    ///   place of sums over nodes or over single samples, and in place of a method that is no
    ///   product, whole rays are integrated to a relative 1e-4: a table would be looked up
    ///   faster, but takes longer to make than the rays of a picture.
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
