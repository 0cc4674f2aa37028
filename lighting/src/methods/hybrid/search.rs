//! Where a ray first may be in shadow, or in the light.

use glam::{DVec3, Vec3};
use gpu_backend::Host;

use super::cells::Cells;
use super::lit_volumes::LitVolumes;
use super::picture::Picture;
use super::volumes::ShadowVolumes;
use crate::shadow_map::line::cube_face;
use crate::{Interval, Ray};

/// A step past a border, relative to the distance from the light: some roundings of an
/// f32, as a shader has them.
pub(super) const PAST: f64 = 2e-6;

/// Levels below the top at which a search begins.
pub(super) const START: u32 = 2;

/// Pictures that a ray goes through, at most, and a few more for roundings at their
/// borders.
pub(super) const MOST_PICTURES: u32 = 16;

/// Cells that are looked at in a picture, at most.
pub(super) const MOST_TURNS: u32 = 4096;

/// A ray as a light sees it. Positions on it are measured from the point that is
/// closest to the light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// From the light's origin to the position 0.
    base: DVec3,
    direction: DVec3,
    /// Square of the length of `base`.
    h2: f64,
    h: f64,
    /// Distance from the eye at the position 0.
    foot: f64,
}

impl Line {
    /// `origin` is that of the light's pictures.
    pub(super) fn new(ray: &Ray, origin: Vec3) -> Self {
        let v = (ray.origin() - origin).as_dvec3();
        // The stored direction is a unit vector to f32 precision only.
        let direction = ray.direction().as_dvec3().normalize();
        let foot = -v.dot(direction);
        let base = v + foot * direction;
        let h2 = base.length_squared();
        Self {
            base,
            direction,
            h2,
            h: h2.sqrt(),
            foot,
        }
    }

    /// The same line in the other direction.
    fn reversed(self) -> Self {
        Self {
            direction: -self.direction,
            ..self
        }
    }

    /// How far rounding may take a position.
    fn past(&self, s: f64) -> f64 {
        PAST * (s.abs() + self.h) + 1e-20
    }

    /// The same for a distance from the eye.
    fn margin(&self, s: f64) -> f64 {
        self.past(s) + PAST * self.foot.abs()
    }
}

/// The ray in a picture.
struct Sight<'a> {
    picture: &'a Picture,
    index: usize,
    /// Homogeneous texels at the position 0, and their slope.
    at: DVec3,
    slope: DVec3,
    /// Depth at the position 0 in parallel light, and its slope.
    depth: [f64; 2],
}

/// The kind of volumes that a search looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    /// Everything that is farther away than the value of its cell.
    Shadow,
    /// Everything that is no farther away than that, or in no picture.
    Light,
}

/// Volumes of shadow or of light, and how they are looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    cells: &'a Cells,
    values: &'a [f32],
    sought: Sought,
}

impl ShadowVolumes<Host> {
    pub(super) fn search(&self) -> Search<'_> {
        Search {
            cells: &self.cells,
            values: &self.near,
            sought: Sought::Shadow,
        }
    }

    /// The part of `whole` outside of which a ray is in no shadow volume; `None` if it is
    /// in none at all. Volumes are told apart down to cells that are as long as
    /// `shortest` along the ray. Adds the number of cells that were looked at.
    pub(super) fn span(
        &self,
        line: &Line,
        whole: Interval,
        shortest: f32,
        cells: &mut u32,
    ) -> Option<Interval> {
        self.search().span(line, whole, shortest, cells)
    }

    /// Whether a point is in a shadow volume of the finest level.
    pub(super) fn contains(&self, point: Vec3) -> bool {
        let Cells {
            origin,
            pictures,
            cell,
            side,
            ..
        } = &self.cells;
        let v = (point - *origin).as_dvec3();
        let index = match pictures.len() {
            1 => 0,
            _ => cube_face(v),
        };
        let picture = &pictures[index];
        let at = picture.of_point(v);
        let cell = [at.x, at.y].map(|t| t / (at.z * f64::from(*cell)));
        let width = f64::from(*side);
        if !(at.z > 0.0 && cell.iter().all(|t| (0.0..width).contains(t))) {
            return false;
        }
        let depth = match picture.is_central() {
            true => v.length(),
            false => v.dot(picture.forward()),
        };
        let index = self.cells.index(index, 0, cell.map(|t| t as u32));
        depth > f64::from(self.near[index])
    }
}

impl LitVolumes<Host> {
    pub(super) fn search(&self) -> Search<'_> {
        Search {
            cells: &self.cells,
            values: &self.far,
            sought: Sought::Light,
        }
    }
}

impl Search<'_> {
    /// The part of `whole` outside of which a ray is in no volume; `None` if it is in none
    /// at all. Volumes are told apart down to cells that are as long as `shortest` along
    /// the ray. Adds the number of cells that were looked at.
    pub(super) fn span(
        &self,
        line: &Line,
        whole: Interval,
        shortest: f32,
        cells: &mut u32,
    ) -> Option<Interval> {
        let front = self.front(line, whole, shortest, cells)?;
        let rest = Interval::new(front, whole.end);
        let back = self.back(line, rest, shortest, cells)?;
        Some(Interval::new(front, back))
    }

    /// Where a part of a ray comes to the first volume.
    pub(super) fn front(
        &self,
        line: &Line,
        part: Interval,
        shortest: f32,
        cells: &mut u32,
    ) -> Option<f32> {
        let ends = [part.start, part.end].map(|x| f64::from(x) - line.foot);
        let front = self.first(line, ends, f64::from(shortest), cells)?;
        let front = front - line.margin(front) + line.foot;
        Some((front as f32).clamp(part.start, part.end))
    }

    /// Where it leaves the last one.
    pub(super) fn back(
        &self,
        line: &Line,
        part: Interval,
        shortest: f32,
        cells: &mut u32,
    ) -> Option<f32> {
        let ends = [part.end, part.start].map(|x| line.foot - f64::from(x));
        let back = -self.first(&line.reversed(), ends, f64::from(shortest), cells)?;
        let back = back + line.margin(back) + line.foot;
        Some((back as f32).clamp(part.start, part.end))
    }

    /// The first position of a part of a line that may be in a volume.
    fn first(
        &self,
        line: &Line,
        [start, end]: [f64; 2],
        shortest: f64,
        cells: &mut u32,
    ) -> Option<f64> {
        let Cells {
            pictures,
            resolution,
            ..
        } = self.cells;
        let mut s = start;
        for _ in 0..MOST_PICTURES {
            if !(s < end) {
                return None;
            }
            let past = s + line.past(s);
            let index = match pictures.len() {
                1 => 0,
                _ => cube_face(line.base + past * line.direction),
            };
            let sight = Sight::new(&pictures[index], index, line);
            // A position on the border of a picture may be rounded to either side, so a texel
            // around a picture counts as part of it. Light may be in the neighbour's cells
            // alone, so that the parts overlap when light is sought. Everything outside of a
            // single picture is lit: its border is moved inwards by a texel.
            let texel = match (self.sought, pictures.len()) {
                (Sought::Light, 1) => -1.0,
                _ => 1.0,
            };
            let from = match self.sought {
                Sought::Shadow => s,
                Sought::Light => start,
            };
            let [from, to] = sight.inside(f64::from(*resolution), texel, [from, end]);
            let is_small = *resolution <= 2;
            if texel < 0.0 && (is_small || !(from <= s && s < to)) {
                return Some(s);
            }
            if from < to
                && let Some(found) = self.first_in(line, &sight, [from, to], shortest, cells)
            {
                return Some(found);
            }
            if pictures.len() == 1 {
                return (texel < 0.0 && to < end).then_some(to);
            }
            s = to.max(past);
        }
        Some(s)
    }

    /// The same within a picture.
    fn first_in(
        &self,
        line: &Line,
        sight: &Sight<'_>,
        [start, end]: [f64; 2],
        shortest: f64,
        cells: &mut u32,
    ) -> Option<f64> {
        let Sight { at, slope, .. } = *sight;
        // Texels rise or fall all along the line, so the next border of a cell is always the
        // same one of the two: 1 where they rise.
        let next = [0, 1].map(|i| u32::from(slope[i] * at.z - at[i] * slope.z >= 0.0));
        let finest = f64::from(self.cells.cell);
        let mut level = self.cells.top().saturating_sub(START);
        let mut s = start;
        for _ in 0..MOST_TURNS {
            if !(s < end) {
                return None;
            }
            *cells += 1;
            let width = self.cells.side >> level;
            let size = finest * f64::from(1_u32 << level);
            let here = at + s * slope;
            let scale = 1.0 / (here.z * size);
            // Conversions saturate, and NaN, at the light itself, is 0.
            let cell = [here.x, here.y].map(|t| ((t * scale) as u32).min(width - 1));
            let border = |axis: usize| {
                let number = cell[axis] + next[axis];
                let texel = size * f64::from(number);
                let towards = slope[axis] - texel * slope.z;
                // Borders parallel to the line or beyond its vanishing point are never met,
                // and those of the picture end the part. A border right here is met, whatever
                // rounding does.
                let ahead = if next[axis] == 1 { towards } else { -towards };
                match ahead > 0.0 && (1..width).contains(&number) {
                    true => ((texel * at.z - at[axis]) / towards).max(s),
                    false => f64::INFINITY,
                }
            };
            let [x, y] = [border(0), border(1)];
            let exit = x.min(y).min(end);
            let value = self.values[self.cells.index(sight.index, level, cell)];
            let entry = sight.entry(line, self.sought, f64::from(value), [s, exit]);
            let Some(entry) = entry else {
                s = exit + line.past(exit);
                let crossed = usize::from(y < x);
                // This may be the border of the coarser cell, too.
                if (cell[crossed] + next[crossed]) % 2 == 0 && level < self.cells.top() {
                    level += 1;
                }
                continue;
            };
            s = entry;
            if level == 0 || exit - s <= shortest {
                return Some(s);
            }
            level -= 1;
        }
        Some(s)
    }
}

impl<'a> Sight<'a> {
    fn new(picture: &'a Picture, index: usize, line: &Line) -> Self {
        let forward = picture.forward();
        Self {
            picture,
            index,
            at: picture.of_point(line.base),
            slope: picture.of_direction(line.direction),
            depth: [line.base.dot(forward), line.direction.dot(forward)],
        }
    }

    /// The part within the picture, and so many texels around it.
    fn inside(&self, resolution: f64, texels: f64, [mut start, mut end]: [f64; 2]) -> [f64; 2] {
        let [p, d] = [self.at, self.slope];
        let last = resolution + texels;
        for (p, d) in [
            (p.x + texels * p.z, d.x + texels * d.z),
            (p.y + texels * p.z, d.y + texels * d.z),
            (last * p.z - p.x, last * d.z - d.x),
            (last * p.z - p.y, last * d.z - d.y),
        ] {
            let crossing = -p / d;
            if d > 0.0 {
                start = start.max(crossing);
            } else if d < 0.0 {
                end = end.min(crossing);
            } else if p < 0.0 {
                end = start;
            }
        }
        [start, end]
    }

    /// The first position from `s` to `exit` that is farther away than `value`, or no
    /// farther.
    #[inline]
    fn entry(&self, line: &Line, sought: Sought, value: f64, [s, exit]: [f64; 2]) -> Option<f64> {
        if self.picture.is_central() {
            let square = value.max(0.0) * value.max(0.0) - line.h2;
            match sought {
                Sought::Shadow if s * s > square => Some(s),
                Sought::Shadow => (exit * exit > square).then(|| square.sqrt().clamp(s, exit)),
                Sought::Light if s * s <= square => Some(s),
                // The position at which the ray comes as close to the light as the stored
                // distance.
                Sought::Light => (s < 0.0 && square >= 0.0 && -square.sqrt() <= exit)
                    .then(|| (-square.sqrt()).clamp(s, exit)),
            }
        } else {
            let [base, slope] = self.depth;
            let is_in = |s: f64| (base + s * slope > value) == (sought == Sought::Shadow);
            if is_in(s) {
                return Some(s);
            }
            is_in(exit).then(|| ((value - base) / slope).clamp(s, exit))
        }
    }
}
