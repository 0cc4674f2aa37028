//! Two sources, each of which knows some of the blockers.

use glam::Vec3;

use super::{Behind, LitInterval, PointVisibility, Share, SurfaceShadow, VisibilitySource};
use crate::direct_light::ShadowsOfMany;
use crate::{Interval, LightPath};

/// The light that passes the blockers of both sources: lit where both are lit, with the product
/// of their visibilities. Two sources of visibility at points, or at points of surfaces, are
/// combined in the same way.
///
/// One use are static and dynamic casters: shadows baked for the scenery, and a small shadow
/// map of what moves in it, rendered anew for each frame. Another is a shadow map of everything
/// opaque beside a transmittance map, which has fewer texels, of everything else.
///
/// Cost: that of both sources, and a step for each of their intervals.
#[derive(Debug, Clone, Copy)]
pub struct Both<A, B>(pub A, pub B);

impl<A, B> VisibilitySource for Both<A, B>
where
    A: VisibilitySource,
    B: VisibilitySource,
    A::Share: Behind<B::Share>,
{
    type Share = <A::Share as Behind<B::Share>>::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Self::Share>>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        self.0.lit_intervals(path, &mut a);
        if a.is_empty() {
            return;
        }
        self.1.lit_intervals(path, &mut b);
        product(&a, &b, lit);
    }
}

impl<A, B> PointVisibility for Both<A, B>
where
    A: PointVisibility,
    B: PointVisibility,
    A::Share: Behind<B::Share>,
{
    type Share = <A::Share as Behind<B::Share>>::Share;

    fn visibility(&self, point: Vec3) -> Self::Share {
        self.0.visibility(point).behind(self.1.visibility(point))
    }

    fn visibility_between(&self, from: Vec3, to: Vec3) -> Self::Share {
        let other = self.1.visibility_between(from, to);
        self.0.visibility_between(from, to).behind(other)
    }
}

impl<A: SurfaceShadow, B: SurfaceShadow> SurfaceShadow for Both<A, B> {
    fn visibility(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let share = self.0.visibility(point, normal);
        match share == Vec3::ZERO {
            true => share,
            false => share * self.1.visibility(point, normal),
        }
    }
}

impl<A: ShadowsOfMany, B: ShadowsOfMany> ShadowsOfMany for Both<A, B> {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let share = self.0.visibility(light, point, normal);
        match share == Vec3::ZERO {
            true => share,
            false => share * self.1.visibility(light, point, normal),
        }
    }
}

/// Appends the intersection of two lists of lit intervals, each in order along the ray.
pub(crate) fn product<A: Behind<B>, B: Share>(
    a: &[LitInterval<A>],
    b: &[LitInterval<B>],
    lit: &mut Vec<LitInterval<A::Share>>,
) {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    while let (Some(x), Some(y)) = (a.peek(), b.peek()) {
        let start = x.interval.start.max(y.interval.start);
        let end = x.interval.end.min(y.interval.end);
        let visibility = x.visibility.behind(y.visibility);
        if start < end && !visibility.is_dark() {
            lit.push(LitInterval {
                interval: Interval::new(start, end),
                visibility,
            });
        }
        if x.interval.end < y.interval.end {
            a.next();
        } else {
            b.next();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(parts: &[(f32, f32, f32)]) -> Vec<LitInterval> {
        let part = |&(start, end, visibility)| LitInterval {
            interval: Interval::new(start, end),
            visibility,
        };
        parts.iter().map(part).collect()
    }

    #[test]
    fn a_product_is_the_product_at_every_point() {
        let forever = f32::INFINITY;
        let lists = [
            list(&[]),
            list(&[(0.0, forever, 1.0)]),
            list(&[(1.0, 2.0, 0.5), (2.0, 3.0, 0.25), (5.0, forever, 1.0)]),
            list(&[(0.5, 1.5, 0.5), (2.5, 5.0, 1.0), (5.0, 5.5, 0.5)]),
            list(&[(3.0, 5.0, 1.0)]),
        ];
        let at = |list: &[LitInterval], x: f32| {
            let inside = |part: &&LitInterval| part.interval.start <= x && x < part.interval.end;
            list.iter().find(inside).map_or(0.0, |part| part.visibility)
        };
        for a in &lists {
            for b in &lists {
                let mut found = Vec::new();
                product(a, b, &mut found);
                for i in 0..80 {
                    let x = 0.1 * i as f32 + 0.05;
                    assert_eq!(at(&found, x), at(a, x) * at(b, x), "{x}: {a:?} {b:?}");
                }
                let ordered = |w: &[LitInterval]| w[0].interval.end <= w[1].interval.start;
                assert!(found.windows(2).all(ordered), "{found:?}");
            }
        }
    }
}
