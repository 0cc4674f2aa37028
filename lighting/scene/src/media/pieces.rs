//! The pieces of a line on which all coefficients are polynomials or exponentials.

use std::iter::Peekable;

use glam::DVec3;

use super::{Ball, Media, MediaPart, Scattering};
use crate::{DensityGrid, Medium, OccupiedCells};

/// The pieces of a line through [`Media`], from front to back: see
/// [`Media::along`].
///
/// Pieces follow each other without gaps; pieces without any medium are included. Each piece
/// borrows memory from this object, so that a ray allocates only once. This is why there is
/// [`advance`](MediaPieces::advance), to be called in a loop, instead of an iterator.
#[derive(Debug)]
pub struct MediaPieces<'a> {
    media: &'a Media<'a>,
    origin: DVec3,
    direction: DVec3,
    at: f64,
    end: f64,
    depth: DVec3,
    /// The range of the homogeneous medium, with the medium.
    even: Option<(f64, f64, Medium)>,
    grids: Vec<(&'a DensityGrid, Peekable<OccupiedCells<'a>>)>,
    /// Chords of balls, sorted by their start, and how many of them have been reached.
    chords: Vec<Chord<'a>>,
    met: usize,
    /// The chords that contain the current position.
    open: Vec<Chord<'a>>,
    parts: Vec<MediaPart<'a>>,
}

/// The part of a line in a ball.
#[derive(Debug, Clone, Copy)]
struct Chord<'a> {
    ball: &'a Ball<'a>,
    middle: f64,
    half: f64,
}

impl<'a> Chord<'a> {
    fn new(ball: &'a Ball<'a>, origin: DVec3, direction: DVec3) -> Option<Self> {
        let offset = ball.centre - origin;
        // A cross product keeps the digits next to the centre.
        let aside2 = direction.cross(offset).length_squared();
        let half2 = ball.radius * ball.radius - aside2;
        (half2 > 0.0).then(|| Self {
            ball,
            middle: offset.dot(direction),
            half: half2.sqrt(),
        })
    }

    fn start(&self) -> f64 {
        self.middle - self.half
    }

    fn end(&self) -> f64 {
        self.middle + self.half
    }
}

impl<'a> MediaPieces<'a> {
    pub(super) fn new(
        media: &'a Media<'a>,
        origin: DVec3,
        direction: DVec3,
        from: f64,
        to: f64,
    ) -> Self {
        let even = media.medium.and_then(|medium| {
            let (start, end) = inside(&medium, origin, direction, from, to)?;
            Some((start, end, medium))
        });
        let grids = media.grids.iter().map(|&grid| {
            let walk = grid.occupied_cells_along(origin, direction, from, to);
            (grid, walk.peekable())
        });
        let mut chords: Vec<_> = media
            .balls
            .iter()
            .filter_map(|ball| Chord::new(ball, origin, direction))
            .filter(|chord| chord.end() > from && chord.start() < to)
            .collect();
        chords.sort_by(|a, b| a.start().total_cmp(&b.start()));
        Self {
            media,
            origin,
            direction,
            at: from,
            end: to,
            depth: DVec3::ZERO,
            even,
            grids: grids.collect(),
            chords,
            met: 0,
            open: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// The next piece, `None` at the end of the line.
    pub fn advance(&mut self) -> Option<MediaPiece<'_>> {
        let start = self.at;
        if !(start < self.end) {
            return None;
        }
        let mut end = self.end;
        let inside = |from: f64, to: f64, end: &mut f64| {
            let next = if from > start { from } else { to };
            if next > start {
                *end = end.min(next);
            }
            from <= start && start < to
        };
        self.parts.clear();
        if let Some((from, to, medium)) = &self.even
            && inside(*from, *to, &mut end)
        {
            self.parts.push(MediaPart::even(medium));
        }
        if let Some(fog) = &self.media.height_fog {
            let slope = self.direction.y;
            let part = MediaPart::height(fog, self.origin.y + start * slope, slope);
            self.parts.push(part);
        }
        for (_, walk) in &mut self.grids {
            while walk.next_if(|span| span.to <= start).is_some() {}
            if let Some(span) = walk.peek() {
                inside(span.from, span.to, &mut end);
            }
        }
        self.open.retain(|chord| chord.end() > start);
        while let Some(chord) = self.chords.get(self.met)
            && chord.start() <= start
        {
            if chord.end() > start {
                self.open.push(*chord);
            }
            self.met += 1;
        }
        if let Some(next) = self.chords.get(self.met) {
            end = end.min(next.start());
        }
        for chord in &self.open {
            end = end.min(chord.end());
        }
        // The end of the piece is known now, so its media can be collected.
        for (grid, walk) in &mut self.grids {
            if let Some(span) = walk.peek()
                && span.from <= start
            {
                self.parts
                    .push(MediaPart::cell(grid, span.part(start, end)));
            }
        }
        for chord in &self.open {
            let (middle, half) = (chord.middle, chord.half);
            self.parts
                .push(MediaPart::ball(chord.ball, half, middle, start, end));
        }
        self.parts.retain(|part| !part.is_nothing());
        self.at = end;
        let length = end - start;
        let depths = self.parts.iter().map(|part| part.depth_to(length, length));
        let piece = MediaPiece {
            start,
            end,
            depth_before: self.depth,
            own_depth: depths.sum(),
            parts: &self.parts,
        };
        self.depth += piece.own_depth;
        Some(piece)
    }
}

/// A piece of a line, on which each medium's coefficients are those of one
/// polynomial or exponential. Distances are those of the line, m.
#[derive(Debug, Clone, Copy)]
pub struct MediaPiece<'a> {
    start: f64,
    end: f64,
    depth_before: DVec3,
    own_depth: DVec3,
    parts: &'a [MediaPart<'a>],
}

impl<'a> MediaPiece<'a> {
    /// Where it starts.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Where it ends; may be infinite.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// The optical depth of all pieces before it.
    pub fn depth_before(&self) -> DVec3 {
        self.depth_before
    }

    /// True if there is no medium on it.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// True if a grid or a particle is on it.
    pub fn has_smoke(&self) -> bool {
        self.parts.iter().any(MediaPart::is_smoke)
    }

    /// True if a medium on it emits light.
    pub fn emits(&self) -> bool {
        self.parts.iter().any(MediaPart::emits)
    }

    /// True if neither the extinction nor the emission of any medium changes along it.
    pub fn is_even(&self) -> bool {
        self.parts.iter().all(MediaPart::is_even)
    }

    /// The emission of all media at `t` on this piece, radiance per metre.
    pub fn emission(&self, t: f64) -> DVec3 {
        let emitting = self.parts.iter().filter(|part| part.emits());
        emitting.map(|part| self.scattering(part, t).emission).sum()
    }

    /// The media on it.
    pub fn parts(&self) -> &'a [MediaPart<'a>] {
        self.parts
    }

    /// The optical depth of this piece.
    pub fn optical_depth(&self) -> DVec3 {
        self.own_depth
    }

    /// The optical depth from the start of the line to `t`, which is on this piece.
    pub fn depth_to(&self, t: f64) -> DVec3 {
        self.depth_before + self.own_depth_to(t)
    }

    /// The optical depth from the start of this piece to `t` on it.
    pub fn own_depth_to(&self, t: f64) -> DVec3 {
        if t == self.end {
            return self.own_depth;
        }
        if t == self.start {
            return DVec3::ZERO;
        }
        let length = self.end - self.start;
        let depths = self
            .parts
            .iter()
            .map(|part| part.depth_to(t - self.start, length));
        depths.sum()
    }

    /// The coefficients of one of its [parts](MediaPiece::parts) at `t`, which is on
    /// this piece.
    pub fn scattering(&self, part: &MediaPart<'_>, t: f64) -> Scattering {
        part.at(t - self.start, self.end - self.start)
    }

    /// The albedo of one of its [parts](MediaPiece::parts) around `t` on this piece: the share
    /// of its extinction that is scattering.
    pub fn albedo(&self, part: &MediaPart<'_>, t: f64) -> DVec3 {
        part.albedo(t - self.start, self.end - self.start)
    }

    /// The extinction coefficient at `t` on this piece, 1/m.
    pub fn extinction(&self, t: f64) -> DVec3 {
        let parts = self.parts.iter();
        parts.map(|part| self.scattering(part, t).extinction).sum()
    }
}

/// The part of a line in the homogeneous medium, `None` if it is empty.
pub(super) fn inside(
    medium: &Medium,
    origin: DVec3,
    direction: DVec3,
    from: f64,
    to: f64,
) -> Option<(f64, f64)> {
    let Some(bounds) = medium.bounds() else {
        return Some((from, to));
    };
    let corners = [bounds.min(), bounds.max()].map(|corner| corner.as_dvec3());
    clip(corners, origin, direction, from, to)
}

/// The optical depth of a ball between two distances.
pub(super) fn depth_of_ball(
    ball: &Ball<'_>,
    origin: DVec3,
    direction: DVec3,
    from: f64,
    to: f64,
) -> f64 {
    let Some(chord) = Chord::new(ball, origin, direction) else {
        return 0.0;
    };
    let (from, to) = (from.max(chord.start()), to.min(chord.end()));
    if from >= to {
        return 0.0;
    }
    ball.cubic(chord.half, chord.middle, from, to).mean() * (to - from)
}

/// The part of a line in a box; `None` if it is empty or a single point.
fn clip(
    [min, max]: [DVec3; 2],
    origin: DVec3,
    direction: DVec3,
    mut from: f64,
    mut to: f64,
) -> Option<(f64, f64)> {
    for axis in 0..3 {
        let (low, high) = (min[axis] - origin[axis], max[axis] - origin[axis]);
        let slope = direction[axis];
        if slope == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (low / slope, high / slope);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from < to).then_some((from, to))
}
