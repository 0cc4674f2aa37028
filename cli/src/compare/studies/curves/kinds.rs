//! The kinds of curves.

use std::fmt::Debug;

use transmittance::baseline::{
    Captured, Deep, DeepCurve, FourierCurve, MomentCurve, Moments, OpacityCurve, Range,
    Uncompressed,
};
use transmittance::{Accumulate, Curve, Evaluate, Linear, Maximum, Packed, Stream};

use super::Family;
use crate::failure::Failure;

/// A kind of curves at a setting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Named {
    pub(crate) family: Family,
    /// Nodes, slices, terms, ε.
    pub(crate) setting: String,
}

/// A visitor of all kinds.
pub(crate) trait Visit {
    /// Curves that start as copies of `clear` and are stored as a `T` of so many `bytes`.
    fn kind<A, T>(&mut self, name: Named, clear: A, bytes: impl Fn(&T) -> usize + 'static)
    where
        A: Accumulate + Clone + Sync + 'static,
        A::Curve: Into<T>,
        T: Evaluate + Debug + Send + Sync + 'static;
}

/// A range around `tight` that is `looser` times as long.
pub(crate) fn range(looser: f64, [near, far]: [f32; 2]) -> Result<Range, Failure> {
    let (near, far) = (f64::from(near), f64::from(far));
    let (middle, half) = (0.5 * (near + far), 0.5 * looser * (far - near));
    Ok(Range::new(
        ((middle - half) as f32).next_down(),
        ((middle + half) as f32).next_up(),
    )?)
}

/// Shows the visitor every kind at every setting, those that need a range of depths with this
/// one.
pub(crate) fn visit_all(range: Range, visit: &mut impl Visit) -> Result<(), Failure> {
    paper::<4>(visit);
    paper::<8>(visit);
    paper::<12>(visit);
    paper::<16>(visit);
    area::<4>(visit);
    area::<8>(visit);
    area::<12>(visit);
    area::<16>(visit);
    maximum::<8>(visit);
    maximum::<16>(visit);
    let slices = OpacityCurve::<32>::new(range);
    let bytes = |_: &OpacityCurve<32>| 4 * 32;
    visit.kind(named(Family::Opacity, 32), slices, bytes);
    let terms = FourierCurve::<16>::new(range);
    let bytes = |_: &FourierCurve<16>| 8 * 16;
    visit.kind(named(Family::Fourier, 16), terms, bytes);
    for epsilon in [0.01, 0.002] {
        let bytes = |curve: &DeepCurve| 8 * curve.len();
        visit.kind(named(Family::Deep, epsilon), Deep::new(epsilon)?, bytes);
    }
    for count in [4, 6, 8] {
        let bytes = move |_: &MomentCurve| 4 * (count + 1);
        visit.kind(
            named(Family::Moments, count),
            Moments::new(count, range)?,
            bytes,
        );
    }
    let bytes = |curve: &Uncompressed| 8 * curve.len();
    visit.kind(named(Family::Uncompressed, "all"), Captured::new(), bytes);
    Ok(())
}

/// The name of a kind.
pub(crate) fn named(family: Family, setting: impl ToString) -> Named {
    Named {
        family,
        setting: setting.to_string(),
    }
}

fn paper<const N: usize>(visit: &mut impl Visit) {
    let bytes = |_: &Packed<N, Linear>| size_of::<Packed<N, Linear>>();
    visit.kind(named(Family::Paper, N), Curve::<N, Linear>::new(), bytes);
}

fn area<const N: usize>(visit: &mut impl Visit) {
    let bytes = |_: &Packed<N>| size_of::<Packed<N>>();
    visit.kind(named(Family::Area, N), Stream::<N>::new(), bytes);
}

fn maximum<const N: usize>(visit: &mut impl Visit) {
    let bytes = |_: &Packed<N>| size_of::<Packed<N>>();
    let clear = Stream::<N, Maximum>::new();
    visit.kind(named(Family::Maximum, N), clear, bytes);
}
