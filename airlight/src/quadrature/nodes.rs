//! Where a quadrature evaluates its integrand: the pieces of a segment and the
//! nodes of each.

use super::piece::{Node, Piece, Place, Rule, Span};
use super::profile::{self, Pattern};
use super::{FADE, FARTHEST, GROWTH, Quadrature};
use crate::emission::{Emission, Part};
use crate::scaled::{Extent, Scaled};
use crate::side::Side;
use crate::{Phase, Segment, Segment64};

impl<P: Phase> Quadrature<P> {
    /// Nodes for an integrand of the caller's own:
    ///
    /// ```text
    /// ∫ f(x) / d² dx ≈ Σ weight f(x_a + distance)
    /// ```
    ///
    /// for an `f` that is smooth over the segment and of the kind `p exp(−σ_t
    /// (x + d))` times what varies slowly. If several extinctions are
    /// integrated over the same nodes, `sigma_t` is the least: beyond its depth
    /// nothing is looked at. What `f` varies otherwise takes `extra` nodes more
    /// on each piece, 2 for a light outside of the medium; lights with a pattern
    /// have [`Quadrature::nodes_of`]. No piece gets more nodes than the largest
    /// rule has, which is the only one of [`Quadrature::fixed`]. The nodes are in
    /// no particular order. No node if the segment is empty or meets the light.
    pub fn nodes(
        &self,
        sigma_t: f32,
        segment: &Segment,
        extra: usize,
    ) -> impl Iterator<Item = Node> {
        // The attenuation on the way by the start is part of the caller's integrand.
        let scaled = match Scaled::of_lengths(sigma_t.into(), &Segment64::from(*segment)) {
            Extent::Ordinary(scaled) => Some(scaled),
            Extent::Empty | Extent::MeetsLight => None,
        };
        let length = segment.length;
        scaled.into_iter().flat_map(move |scaled| {
            let per_metre = (1.0 / scaled.unit) as f32;
            self.pieces(scaled, extra).flat_map(move |(piece, rule)| {
                rule.nodes().iter().map(move |&(t, weight)| {
                    let mut node = piece.at(t).0;
                    node.weight *= weight * per_metre;
                    // Rounding may put it past the end.
                    node.distance = node.distance.clamp(0.0, length);
                    node
                })
            })
        })
    }

    /// [`Quadrature::nodes`] of a light that is not equally bright in all
    /// directions, whose `emission` is for the same segment and a factor of the
    /// weights:
    ///
    /// ```text
    /// ∫ e(x) f(x) / d² dx ≈ Σ weight f(x_a + distance)
    /// ```
    ///
    /// The segment is divided where the emission is not smooth, and each piece has
    /// as many nodes more as the emission asks for, see [`profile`], besides the
    /// `extra` nodes for what else `f` varies. The tolerance is kept relative to
    /// this light's own airlight, for cones of 0.1° to 180°, lights of limited
    /// range and rays that graze either. With [`Quadrature::fixed`] all pieces
    /// have the same number of nodes.
    pub fn nodes_of(
        &self,
        sigma_t: f32,
        segment: &Segment64,
        emission: &Emission,
        extra: usize,
    ) -> impl Iterator<Item = Node> {
        let Segment64 { s, length, .. } = *segment;
        let emission = *emission;
        emission.parts(segment).flat_map(move |part| {
            let scaled = match Scaled::of_ends(sigma_t.into(), &part.segment, part.end) {
                Extent::Ordinary(scaled) => Some(scaled),
                Extent::Empty | Extent::MeetsLight => None,
            };
            let before = part.segment.s - s;
            let nodes = scaled.map(|scaled| self.places(scaled, emission, part, extra));
            nodes.into_iter().flatten().map(move |(node, _)| Node {
                // Rounding may put it past the end.
                distance: (before + f64::from(node.distance)).clamp(0.0, length) as f32,
                ..node
            })
        })
    }

    /// The nodes of a part with the emission in their weights, 1/m, their
    /// distances from the start of the part, m, and the optical depth since
    /// there.
    pub(super) fn places(
        &self,
        scaled: Scaled,
        emission: Emission,
        part: Part,
        extra: usize,
    ) -> impl Iterator<Item = (Node, f32)> {
        let pattern = Pattern::new(&emission, &part);
        let plain = pattern.extra == 0;
        let deeper = if plain { 0.0 } else { profile::DEEPER };
        let range = emission.fading_range() / scaled.unit;
        let extra = pattern.extra.saturating_add(extra);
        let per_metre = 1.0 / scaled.unit;
        let sides = self.sides(scaled, deeper);
        let pieces = sides.flat_map(move |side| {
            let side = side.fading(range, profile::UNFADED);
            self.cut(side, scaled.unit, extra)
                .map(move |(piece, rule, [start, end])| {
                    (piece, rule, pattern.on(&side, start, end))
                })
        });
        pieces.flat_map(move |(piece, rule, profile)| {
            rule.nodes().iter().map(move |&(t, weight)| {
                let Place {
                    mut node,
                    depth,
                    share,
                    squares,
                } = piece.place(t);
                let emitted = profile.at(share, squares, node.distance);
                node.weight = (f64::from(node.weight * weight * emitted) * per_metre) as f32;
                (node, depth)
            })
        })
    }

    /// The pieces of a segment and a rule for each, with `extra` more nodes.
    pub(super) fn pieces(
        &self,
        segment: Scaled,
        extra: usize,
    ) -> impl Iterator<Item = (Piece, &Rule)> {
        self.sides(segment, 0.0).flat_map(move |side| {
            self.cut(side, segment.unit, extra)
                .map(|(piece, rule, _)| (piece, rule))
        })
    }

    /// The sides of a segment, cut off where nothing that counts is left: at an optical depth
    /// that is larger by `deeper` than for a plain light.
    fn sides(&self, segment: Scaled, deeper: f64) -> impl Iterator<Item = Side> + use<P> {
        let opacity = self.opacity + deeper;
        let far = (self.far * deeper.exp()).min(FARTHEST);
        Side::both(&segment, self.peaks, self.thin()).map(move |mut side| {
            side.reach(opacity, far);
            side
        })
    }

    /// The pieces of a side, a rule for each with `extra` more nodes, and the offsets between
    /// which they lie.
    fn cut(
        &self,
        side: Side,
        unit: f64,
        extra: usize,
    ) -> impl Iterator<Item = (Piece, &Rule, [f64; 2])> {
        let mut start = 0.0;
        std::iter::from_fn(move || {
            (start < side.extent).then(|| {
                let end = side.next(start, GROWTH, FADE);
                let (piece, span) = Piece::new(&side, start, end, unit);
                let ends = [start, end];
                start = end;
                (piece, self.rule_for(span, extra), ends)
            })
        })
    }

    fn rule_for(&self, span: Span, extra: usize) -> &Rule {
        let plain = self.plain - 1;
        let found = self.rules[..plain]
            .iter()
            .position(|(_, most)| span.within(most));
        let last = self.rules.len() - 1;
        &self.rules[found.unwrap_or(plain).saturating_add(extra).min(last)].0
    }
}
