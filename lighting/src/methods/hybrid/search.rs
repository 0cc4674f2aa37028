//! Where a ray first may be in shadow.

use glam::{DVec3, Vec3};
use gpu_backend::Host;

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

impl ShadowVolumes<Host> {
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
        let [start, end] = [whole.start, whole.end].map(|x| f64::from(x) - line.foot);
        let shortest = f64::from(shortest);
        let front = self.first(line, [start, end], shortest, cells)?;
        let back = -self.first(&line.reversed(), [-end, -front], shortest, cells)?;
        let [front, back] = [front - line.margin(front), back + line.margin(back)];
        let at = |s: f64| ((s + line.foot) as f32).clamp(whole.start, whole.end);
        Some(Interval::new(at(front), at(back)))
    }

    /// Where a part of a ray comes to the first shadow volume.
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

    /// Whether a point is in a shadow volume of the finest level.
    pub(super) fn contains(&self, point: Vec3) -> bool {
        let v = (point - self.origin()).as_dvec3();
        let pictures = self.pictures();
        let index = match pictures.len() {
            1 => 0,
            _ => cube_face(v),
        };
        let picture = &pictures[index];
        let at = picture.of_point(v);
        let cell = [at.x, at.y].map(|t| t / (at.z * f64::from(self.cell())));
        let width = f64::from(self.side());
        if !(at.z > 0.0 && cell.iter().all(|t| (0.0..width).contains(t))) {
            return false;
        }
        let depth = match picture.is_central() {
            true => v.length(),
            false => v.dot(picture.forward()),
        };
        depth > f64::from(self.near_of(index, 0, cell.map(|t| t as u32)))
    }

    /// The first position of a part of a line that may be in shadow.
    fn first(
        &self,
        line: &Line,
        [start, end]: [f64; 2],
        shortest: f64,
        cells: &mut u32,
    ) -> Option<f64> {
        let pictures = self.pictures();
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
            let [from, to] = sight.inside(f64::from(self.resolution()), [s, end]);
            if from < to
                && let Some(found) = self.first_in(line, &sight, [from, to], shortest, cells)
            {
                return Some(found);
            }
            if pictures.len() == 1 {
                return None;
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
        // Which border of a cell comes next: texels rise or fall all along the line.
        let next = [0, 1].map(|i| u32::from(slope[i] * at.z - at[i] * slope.z >= 0.0));
        let finest = f64::from(self.cell());
        let mut level = self.top().saturating_sub(START);
        let mut s = start;
        for _ in 0..MOST_TURNS {
            if !(s < end) {
                return None;
            }
            *cells += 1;
            let width = self.side() >> level;
            let size = finest * f64::from(1_u32 << level);
            let here = at + s * slope;
            let scale = 1.0 / (here.z * size);
            // Conversions saturate, and NaN, at the light itself, is 0.
            let cell = [here.x, here.y].map(|t| ((t * scale) as u32).min(width - 1));
            let border = |axis: usize| {
                let number = cell[axis] + next[axis];
                let texel = size * f64::from(number);
                let towards = slope[axis] - texel * slope.z;
                // Borders along the line or beyond its vanishing point are never met, and
                // where the picture ends so does the part. One that is right here is met,
                // whatever rounding says.
                let ahead = if next[axis] == 1 { towards } else { -towards };
                match ahead > 0.0 && (1..width).contains(&number) {
                    true => ((texel * at.z - at[axis]) / towards).max(s),
                    false => f64::INFINITY,
                }
            };
            let [x, y] = [border(0), border(1)];
            let exit = x.min(y).min(end);
            let near = f64::from(self.near_of(sight.index, level, cell));
            let Some(entry) = sight.entry(line, near, s, exit) else {
                s = exit + line.past(exit);
                let crossed = usize::from(y < x);
                // Past the border of the coarser cell too?
                if (cell[crossed] + next[crossed]) % 2 == 0 && level < self.top() {
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

    /// The part within the picture, and a texel around it: what is on its border may be
    /// rounded to either side.
    fn inside(&self, resolution: f64, [mut start, mut end]: [f64; 2]) -> [f64; 2] {
        let [p, d] = [self.at, self.slope];
        let last = resolution + 1.0;
        for (p, d) in [
            (p.x + p.z, d.x + d.z),
            (p.y + p.z, d.y + d.z),
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

    /// The first position from `s` to `exit` that is farther away than `near`.
    #[inline]
    fn entry(&self, line: &Line, near: f64, s: f64, exit: f64) -> Option<f64> {
        if self.picture.is_central() {
            let square = near.max(0.0) * near.max(0.0) - line.h2;
            if s * s > square {
                return Some(s);
            }
            (exit * exit > square).then(|| square.sqrt().clamp(s, exit))
        } else {
            let [base, slope] = self.depth;
            if base + s * slope > near {
                return Some(s);
            }
            (base + exit * slope > near).then(|| ((near - base) / slope).clamp(s, exit))
        }
    }
}
