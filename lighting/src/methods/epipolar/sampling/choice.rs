//! Which rays are gathered for a light, and what each pixel is made of.

use glam::{DVec2, Vec3};
use gpu_backend::Cpu;

use super::lines::{Area, Epipole};
use super::samples::{SampledLine, Spacing};
use super::surfaces::Surfaces;
use crate::methods::{FrameInputs, Selection};
use crate::scene::trace::Hit;
use crate::scene::{Emission, Emitter};
use crate::{Interleaving, LightPath, Ray};

/// Stands for the number of a sample where there is none.
pub(super) const NONE: u32 = u32::MAX;

/// Pixels whose two lines count by less than this together are gathered.
const LEAST: f32 = 1.0 / 16.0;

/// Halvings of the number of lines on the way to the epipole, at most.
const MOST_HALVINGS: u32 = 8;

/// What a pixel is made of: light of two lines, each between two samples.
///
/// ```text
/// (1 − across) · line(0) + across · line(1),
/// line(i) = (1 − along_i) · light(samples_i) + along_i · light(samples_i + 1)
/// ```
///
/// A pixel with a ray of its own has it in place of both lines; [`NONE`] is a pixel that
/// the light does not reach. `Mixture` of `fill.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Mixture {
    pub(super) samples: [u32; 2],
    pub(super) along: [f32; 2],
    pub(super) across: f32,
    pub(super) padding: u32,
}

impl Mixture {
    /// A single ray.
    fn one(sample: u32) -> Self {
        Self {
            samples: [sample; 2],
            along: [0.0; 2],
            across: 0.0,
            padding: 0,
        }
    }
}

/// The rays of a picture that are gathered for one light, and what is made of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub(super) rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// The pixel that each ray runs through.
    pixels: Vec<u32>,
    /// One for each pixel of the picture.
    pub(super) mixtures: Vec<Mixture>,
}

/// What is known of a pixel before its rays have numbers.
#[derive(Debug, Clone, Copy)]
enum Found {
    Dark,
    Own,
    Between(Mixture),
}

/// The lines of an area; none where they enter it.
struct Lines<'s, 'a> {
    surfaces: &'s Surfaces<'a>,
    area: Area,
    epipole: Epipole,
    spacing: Spacing,
    /// The number of a line's first sample, and the line.
    lines: Vec<Option<(u32, SampledLine)>>,
}

impl<'s, 'a> Lines<'s, 'a> {
    fn new(
        cpu: &Cpu,
        surfaces: &'s Surfaces<'a>,
        area: Area,
        (epipole, spacing): (Epipole, Spacing),
    ) -> Self {
        let count = (epipole.perimeter() / spacing.lines).ceil().max(4.0);
        let found: Vec<Option<SampledLine>> = cpu.map(count as usize, |index| {
            let line = epipole.line(index as f64 / count * epipole.perimeter())?;
            // Every other line ends half way to the epipole, every fourth at a quarter.
            let halvings = (index as u32).trailing_zeros().min(MOST_HALVINGS);
            let share = match halvings {
                MOST_HALVINGS => 0.0,
                halvings => 0.5_f64.powi(halvings as i32 + 1),
            };
            Some(SampledLine::new(surfaces, area, line, (spacing, share)))
        });
        let mut first = 0;
        let mut lines = Vec::with_capacity(found.len());
        for line in found {
            let samples = line.as_ref().map_or(0, |line| line.samples.len());
            lines.push(line.map(|line| (first, line)));
            first += samples as u32;
        }
        Self {
            surfaces,
            area,
            epipole,
            spacing,
            lines,
        }
    }

    /// The samples of all lines.
    fn samples(&self) -> impl Iterator<Item = (DVec2, u32)> {
        let lines = self.lines.iter().flatten();
        lines.flat_map(|(_, line)| {
            let samples = line.samples.iter();
            samples.map(|sample| (line.line.at(sample.distance.into()), sample.pixel))
        })
    }

    /// What a pixel is made of, if its lines tell.
    fn between(&self, pixel: usize, [x, y]: [u32; 2]) -> Option<Mixture> {
        let [x, y] = [x - self.area.from[0], y - self.area.from[1]].map(f64::from);
        let point = DVec2::new(x + 0.5, y + 0.5);
        let place = self.epipole.place(point)?;
        if self.spacing.at(place.radius) <= 1.0 {
            return None;
        }
        let mut halvings = 0;
        let mut share = 2.0 * place.share;
        while share <= 1.0 && halvings < MOST_HALVINGS {
            share *= 2.0;
            halvings += 1;
        }
        let count = self.lines.len();
        let at = place.border / self.epipole.perimeter() * count as f64;
        // Rounding may reach the end, which is the beginning.
        let first = (at as usize).min(count - 1) >> halvings << halvings;
        let second = (first + (1 << halvings)).min(count);
        let across = ((at - first as f64) / (second - first) as f64).clamp(0.0, 1.0) as f32;
        let taps = [first, second % count].map(|index| {
            let (number, line) = self.lines[index].as_ref()?;
            let tap = line.tap(self.surfaces, self.area, (point, pixel));
            Some((number + tap.index as u32, tap))
        });
        let weight = |i: usize, by_place: f32| {
            taps[i].map_or(0.0, |(_, tap): (u32, _)| by_place * tap.resemblance)
        };
        let weights = [weight(0, 1.0 - across), weight(1, across)];
        let sum = weights[0] + weights[1];
        if sum < LEAST {
            return None;
        }
        let across = weights[1] / sum;
        // A line that does not count may not be there.
        let [a, b] = match (taps[0], taps[1]) {
            (Some(a), Some(b)) => [a, b],
            (Some(a), None) => [a, a],
            (None, Some(b)) => [b, b],
            (None, None) => return None,
        };
        Some(Mixture {
            samples: [a.0, b.0],
            along: [a.1.along, b.1.along],
            across,
            padding: 0,
        })
    }
}

/// Which pixels of a picture a light reaches; `None` if it reaches all of them.
fn reached(cpu: &Cpu, inputs: &FrameInputs<'_>, emitter: &Emitter) -> Option<Vec<bool>> {
    let is_bounded = inputs.medium.bounds().is_some();
    let reaches_all = match emitter {
        Emitter::Directional(_) => true,
        Emitter::Point(point) => {
            point.range() == f32::INFINITY && matches!(point.emission(), Emission::Isotropic)
        }
    };
    if reaches_all && !is_bounded {
        return None;
    }
    Some(cpu.map(inputs.rays.len(), |pixel| {
        LightPath::new(&inputs.rays[pixel], emitter, inputs.medium).is_some()
    }))
}

/// The least area with all pixels that are reached; `None` if there are none.
fn area_of(reached: Option<&[bool]>, size: [u32; 2]) -> Option<Area> {
    let Some(reached) = reached else {
        return Some(Area { from: [0, 0], size });
    };
    let mut bounds: Option<[[u32; 2]; 2]> = None;
    for (row, y) in reached.chunks(size[0] as usize).zip(0..) {
        let Some(first) = row.iter().position(|is_reached| *is_reached) else {
            continue;
        };
        let last = row.iter().rposition(|is_reached| *is_reached)?;
        let [from, to] = bounds.get_or_insert([[first as u32, y], [last as u32, y]]);
        *from = [from[0].min(first as u32), from[1]];
        *to = [to[0].max(last as u32), y];
    }
    let [from, to] = bounds?;
    Some(Area {
        from,
        size: [to[0] - from[0] + 1, to[1] - from[1] + 1],
    })
}

impl Choice {
    /// The rays for one light; the same on any number of threads. `None` if it reaches
    /// no pixel.
    pub(super) fn new(
        cpu: &Cpu,
        surfaces: &Surfaces<'_>,
        emitter: &Emitter,
        spacing: Spacing,
    ) -> Option<Self> {
        let inputs = surfaces.inputs();
        let reached = reached(cpu, inputs, emitter);
        let area = area_of(reached.as_deref(), inputs.size)?;
        // Without lines, every pixel that is reached is gathered by itself.
        let lines = match spacing.samples <= 1.0 {
            true => None,
            false => Epipole::new(inputs.camera, inputs.size, emitter, area)
                .map(|epipole| Lines::new(cpu, surfaces, area, (epipole, spacing))),
        };
        // Nor where lines have more samples than there are pixels: in small areas.
        let pixels = reached.as_ref().map_or(inputs.rays.len(), |reached| {
            reached.iter().filter(|is_reached| **is_reached).count()
        });
        let lines = lines.filter(|lines| lines.samples().count() < pixels);
        let columns = inputs.size[0];
        let found: Vec<Found> = cpu.map(inputs.rays.len(), |pixel| {
            let at = [pixel as u32 % columns, pixel as u32 / columns];
            let is_reached = reached.as_ref().is_none_or(|reached| reached[pixel]);
            if !is_reached || !area.contains(at) {
                return Found::Dark;
            }
            let lines = lines.as_ref();
            lines
                .and_then(|lines| lines.between(pixel, at))
                .map_or(Found::Own, Found::Between)
        });
        let mut choice = Self {
            rays: Vec::new(),
            hits: Vec::new(),
            pixels: Vec::new(),
            mixtures: Vec::with_capacity(found.len()),
        };
        let all = lines.iter().flat_map(Lines::samples);
        let corner = DVec2::from(area.from.map(f64::from));
        for (point, pixel) in all {
            choice.push(inputs, pixel, ray_through(surfaces, corner + point, pixel));
        }
        for (pixel, found) in (0..).zip(found) {
            let mixture = match found {
                Found::Dark => Mixture::one(NONE),
                Found::Between(mixture) => mixture,
                Found::Own => {
                    let number = choice.rays.len() as u32;
                    choice.push(inputs, pixel, inputs.rays[pixel as usize]);
                    Mixture::one(number)
                }
            };
            choice.mixtures.push(mixture);
        }
        Some(choice)
    }

    fn push(&mut self, inputs: &FrameInputs<'_>, pixel: u32, ray: Ray) {
        self.rays.push(ray);
        self.hits.push(inputs.hits[pixel as usize]);
        self.pixels.push(pixel);
    }

    /// The frame of these rays, in place of that of the whole picture.
    pub(super) fn inputs<'a>(&'a self, whole: &FrameInputs<'a>) -> FrameInputs<'a> {
        FrameInputs {
            rays: &self.rays,
            hits: &self.hits,
            selection: Selection {
                pixels: Some(&self.pixels),
                interleaving: Interleaving::NONE,
            },
            ..*whole
        }
    }
}

/// The ray of the eye through a point of the picture, up to what `pixel` sees.
fn ray_through(surfaces: &Surfaces<'_>, point: DVec2, pixel: u32) -> Ray {
    let FrameInputs {
        camera, size, rays, ..
    } = *surfaces.inputs();
    let direction: Vec3 = camera.direction(point.x as f32, point.y as f32, size[0], size[1]);
    let own = rays[pixel as usize];
    let length = surfaces.length(pixel as usize, direction);
    Ray::new(own.origin(), direction, length).unwrap_or(own)
}
