//! Footprints over triangles: which of them need not be rasterised.

use super::Mesh;
use super::texels::{Centres, Texels};
use super::triangle::{Kind, ONE, Triangle};
use crate::depths::TileRect;
use crate::footprint::{Content, Footprints};
use crate::interval::Interval;
use crate::patches::Patch;
use crate::rule::Tile;
use crate::{LightSpace, Resolution, Slices};

/// A footprint and the triangles over it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Column and row, in footprints of the level.
    at: [u32; 2],
    /// Where its list is.
    start: usize,
    end: usize,
    /// Where its list and those of its siblings end together.
    top: usize,
}

impl Part {
    /// The first texel.
    pub(crate) fn origin(self, level: usize) -> [u32; 2] {
        self.at.map(|at| at << (3 + level))
    }
}

/// The working memory of a thread that looks at footprints.
#[derive(Debug)]
pub(crate) struct Scratch<'a> {
    mesh: &'a Mesh,
    /// Whether to find out where nothing has to be rasterised.
    shortcuts: bool,
    /// The lists of all footprints from the whole to the current one.
    lists: Vec<u32>,
    /// Kinds and depths of the triangles over the current one.
    ranges: Vec<(Kind, [f64; 2])>,
    texels: Texels,
}

/// How many times a gap that turns out to be crossed is sought farther in front. More hardly
/// ever helps, and a gap that is missed is found in the quarters.
const RETRIES: usize = 4;

/// Columns over patches of a plane are kept up to the width at which the fifth
/// power of it, about the number of columns that there can be for each of the
/// patches, is this many times the texels of the plane. Tuned on a floor.
const WORTH: f64 = 4.0;

/// How far, relative to its distance, a corner on the near plane may be from
/// it: many times the rounding of its coordinates, and nothing to a slice.
const NEAR_ROUNDING: f64 = 1e-9;

/// The depth, of the kind that triangles have, at which the last slice ends.
fn last(light: &LightSpace) -> f64 {
    match light.slices() {
        Slices::Linear => 1.0,
        Slices::Logarithmic(ends) => -1.0 / ends.far(),
    }
}

/// The slice behind a depth of the kind that triangles have.
pub(super) fn slice(light: &LightSpace, resolution: Resolution, depth: f64) -> u32 {
    let slices = light.slices();
    let depth = match slices {
        Slices::Linear => depth,
        // +∞ stands for nothing, and so does the 0 of infinite distance.
        Slices::Logarithmic(_) if depth >= 0.0 => f64::INFINITY,
        Slices::Logarithmic(_) => -1.0 / depth,
    };
    slices.boundary(resolution, depth)
}

impl<'a> Scratch<'a> {
    pub(crate) fn new(mesh: &'a Mesh, shortcuts: bool) -> Self {
        Self {
            mesh,
            shortcuts,
            lists: Vec::new(),
            ranges: Vec::new(),
            texels: Texels::default(),
        }
    }

    /// The part that is a square of texels.
    pub(crate) fn start(&mut self, tile: TileRect) -> Part {
        let mesh = self.mesh;
        mesh.over(tile, &mut self.lists);
        let (low, high) = self.centres([tile.x, tile.y], tile.side);
        self.lists
            .retain(|&triangle| mesh.triangles[triangle as usize].meets(low, high));
        self.leave_out_hidden(0, low, high);
        Part {
            at: [tile.x / tile.side, tile.y / tile.side],
            start: 0,
            end: self.lists.len(),
            top: self.lists.len(),
        }
    }

    /// Steps of the grid from one texel to the next.
    fn step(&self) -> i32 {
        ONE / self.mesh.resolution.side() as i32
    }

    /// The centres of the first and the last of `side` texels.
    fn centres(&self, origin: [u32; 2], side: u32) -> ([i32; 2], [i32; 2]) {
        let step = self.step();
        let low = origin.map(|at| at as i32 * step + step / 2);
        (low, low.map(|at| at + (side as i32 - 1) * step))
    }

    /// The quarters of a footprint of `level` > 0, each with its triangles.
    fn quarters(&mut self, level: usize, part: Part) -> [Part; 4] {
        let mesh = self.mesh;
        let mut quarters = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| {
            let at = [2 * part.at[0] + dx, 2 * part.at[1] + dy];
            let (low, high) = self.centres(at.map(|at| at << (2 + level)), 4 << level);
            let start = self.lists.len();
            for i in part.start..part.end {
                let triangle = self.lists[i];
                if mesh.triangles[triangle as usize].meets(low, high) {
                    self.lists.push(triangle);
                }
            }
            self.leave_out_hidden(start, low, high);
            Part {
                at,
                start,
                end: self.lists.len(),
                top: 0,
            }
        });
        for quarter in &mut quarters {
            quarter.top = self.lists.len();
        }
        quarters
    }

    /// Leaves those out of the list of a footprint, from `start` on, that are nowhere in it
    /// but behind a surface over all of it, and enclose nothing: all is shadowed there.
    fn leave_out_hidden(&mut self, start: usize, low: [i32; 2], high: [i32; 2]) {
        let triangles = &self.mesh.triangles;
        let open = |number: u32| {
            let triangle = &triangles[number as usize];
            (triangle.kind == Kind::Open).then_some(triangle)
        };
        if self.lists.len() - start < 2 {
            return;
        }
        let nearest = (self.lists[start..].iter())
            .filter_map(|&number| open(number))
            .filter(|triangle| triangle.fills(low, high))
            .fold(f64::INFINITY, |nearest, triangle| {
                nearest.min(triangle.depths(low, high)[1])
            });
        if nearest == f64::INFINITY {
            return;
        }
        let mut end = start;
        for i in start..self.lists.len() {
            let number = self.lists[i];
            if open(number).is_none_or(|triangle| triangle.depths(low, high)[0] <= nearest) {
                self.lists[end] = number;
                end += 1;
            }
        }
        self.lists.truncate(end);
    }

    /// The triangles over each block of `side` texels of a tile: `each` is
    /// given the first texel of the block and their numbers.
    #[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
    pub(crate) fn blocks(
        &mut self,
        tile: TileRect,
        side: u32,
        mut each: impl FnMut([u32; 2], &[u32]),
    ) {
        let level = |side: u32| side.trailing_zeros() as usize - 3;
        let whole = self.start(tile);
        let mut waiting = vec![(level(tile.side), whole)];
        while let Some((at, part)) = waiting.pop() {
            // Lists of the parts that are done are dropped.
            self.lists.truncate(part.top);
            if at == level(side) {
                each(part.origin(at), &self.lists[part.start..part.end]);
            } else {
                waiting.extend(self.quarters(at, part).map(|quarter| (at - 1, quarter)));
            }
        }
    }

    /// The triangle over a footprint, if it is the only one and encloses
    /// nothing.
    fn only_surface(&self, part: Part) -> Option<&Triangle> {
        match self.lists[part.start..part.end] {
            [number] => {
                let triangle = &self.mesh.triangles[number as usize];
                (triangle.kind == Kind::Open).then_some(triangle)
            }
            _ => None,
        }
    }

    /// The slice of all texels of a footprint, if it is under a single surface
    /// that does not leave that slice.
    fn shelf(&self, part: Part, low: [i32; 2], high: [i32; 2]) -> Option<Interval> {
        let triangle = self.only_surface(part)?;
        let slice = |depth| slice(&self.mesh.light, self.mesh.resolution, depth);
        let [enter, exit] = triangle.depths(low, high).map(slice);
        (enter == exit && triangle.fills(low, high)).then_some(Interval { enter, exit })
    }

    /// Depths at which all texels of a footprint can turn, if that can be
    /// seen from the ranges of the triangles alone.
    ///
    /// Up to the nearest back face rays only ever enter solids. If there is a
    /// gap in front of it that no surface crosses, all rays are inside of
    /// equally many solids in it, and one of them says of how many.
    fn gap(&self, part: Part, sample: [i32; 2]) -> Option<Interval> {
        let slice = |depth| slice(&self.mesh.light, self.mesh.resolution, depth);
        let front = |kind: Kind| kind == Kind::Front;
        // Casters behind the last slice are not looked at: they may have been left out.
        let (mut first, mut end) = (f64::INFINITY, last(&self.mesh.light));
        for &(kind, [least, _]) in &self.ranges {
            first = first.min(least);
            if !front(kind) {
                end = end.min(least);
            }
        }
        let side = self.mesh.resolution.side();
        if slice(first) >= side {
            return Some(Interval {
                enter: side,
                exit: side,
            });
        }
        // Solids that the near plane cuts begin there, give or take the rounding of new corners;
        // in front of it nothing tells what is inside of a solid.
        let begin = match self.mesh.light.slices() {
            Slices::Linear => f64::NEG_INFINITY,
            Slices::Logarithmic(ends) => -1.0 / (ends.near() * (1.0 + NEAR_ROUNDING)),
        };
        let mut start = begin;
        for _ in 0..RETRIES {
            let mut nearer = end;
            start = begin;
            for &(kind, [least, most]) in &self.ranges {
                if front(kind) && least < end {
                    if most < end {
                        start = start.max(most);
                    } else {
                        nearer = nearer.min(least);
                    }
                }
            }
            if nearer == end {
                break;
            }
            end = nearer;
            start = f64::INFINITY;
        }
        if start >= end {
            return None;
        }
        // Rays end outside of everything, so that solids that are left behind the gap without
        // being entered there were entered in front of it.
        let mut inside = 0;
        for (&triangle, &(kind, [least, _])) in
            self.lists[part.start..part.end].iter().zip(&self.ranges)
        {
            if least >= end && self.mesh.triangles[triangle as usize].covers(sample) {
                inside += match kind {
                    Kind::Front => -1,
                    Kind::Back => 1,
                    Kind::Open => 0,
                };
            }
        }
        (inside > 0).then(|| Interval {
            enter: slice(start),
            exit: slice(end),
        })
    }
}

impl Footprints for Scratch<'_> {
    type Part = Part;

    fn content(&mut self, level: usize, part: Part, texels: &mut Tile) -> Content<Part> {
        let mesh = self.mesh;
        let side = mesh.resolution.side();
        if part.start == part.end {
            return Content::Uniform(Interval {
                enter: side,
                exit: side,
            });
        }
        let (low, high) = self.centres(part.origin(level), 8 << level);
        if self.shortcuts {
            if let Some(interval) = self.shelf(part, low, high) {
                return Content::Uniform(interval);
            }
            let list = &self.lists[part.start..part.end];
            self.ranges.clear();
            self.ranges.extend(list.iter().map(|&triangle| {
                let triangle = &mesh.triangles[triangle as usize];
                (triangle.kind, triangle.depths(low, high))
            }));
            if let Some(interval) = self.gap(part, low) {
                return Content::Uniform(interval);
            }
        }
        if level == 0 {
            let list = &self.lists[part.start..part.end];
            let slice = |depth| slice(&mesh.light, mesh.resolution, depth);
            let centres = Centres {
                first: low,
                step: self.step(),
            };
            (self.texels).resolve(mesh, list, centres, slice, texels);
            return Content::Texels;
        }
        Content::Quarters(self.quarters(level, part))
    }

    fn leave(&mut self, part: Part) {
        self.lists.truncate(part.top);
    }

    fn patch(&self, level: usize, part: Part) -> Option<Patch> {
        let mesh = self.mesh;
        let triangle = self.only_surface(part)?;
        if !self.shortcuts || *mesh.light.slices() != Slices::Linear {
            return None;
        }
        let side = 8_u32 << level;
        let (width, reach) = (f64::from(side), f64::from(mesh.resolution.side()));
        let texels = 0.5 * triangle.twice_area() as f64 / f64::from(self.step()).powi(2);
        if width.powi(5) > WORTH * texels {
            return None;
        }
        let (low, high) = self.centres(part.origin(level), side);
        // Depths are those of the map, 0 to 1.
        let [least, most] = triangle.depths(low, high);
        if least * reach < width + 1.0 || most * reach > reach - width - 1.0 {
            return None;
        }
        if !triangle.fills(low, high) {
            return None;
        }
        let (slope, error) = triangle.plane(low, high);
        let slope = slope.map(|slope| slope * f64::from(ONE));
        let rise = width * (slope[0].abs() + slope[1].abs());
        Some(Patch {
            at: reach * triangle.depth(low) - 0.5,
            slope,
            // Rounding of the depths, and of what follows from the slopes.
            error: 2.0 * (reach * error + 4.0 * f64::EPSILON * (rise + reach)),
        })
    }
}
