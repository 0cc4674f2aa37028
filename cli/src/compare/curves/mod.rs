//! Curves of transmittance by themselves, without a picture: error, time and
//! memory of every kind on the light rays of hair and smoke.
//!
//! Table 1 and figures 6 and 7 of Salvi et al., "Adaptive Volumetric Shadow
//! Maps", 2010, with errors, which the paper does not have.

mod entries;
mod rays;

use std::fmt::Write;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::scene::procedural::{ponytail, smoke_grid, smoke_particles};
use lighting::scene::{Particle, Particles, StrandPoint, Strands, Translucent};
use lighting::translucent::Casters;

use super::results::{LeftOut, Times};
use crate::failure::Failure;
use crate::progress;
use entries::{Entry, entries, lines_of_all, lines_of_sizes};
use rays::Rays;

/// How many times as long as the blockers the ranges of depths are that methods
/// are told; the first is the tight one.
pub(crate) const RANGES: [f64; 3] = [1.0, 4.0, 10.0];

/// A kind of curve, in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    Paper,
    Area,
    Maximum,
    Opacity,
    Fourier,
    Deep,
    Moments,
    Uncompressed,
}

impl Family {
    pub(crate) const ALL: [Self; 8] = [
        Self::Paper,
        Self::Area,
        Self::Maximum,
        Self::Opacity,
        Self::Fourier,
        Self::Deep,
        Self::Moments,
        Self::Uncompressed,
    ];

    /// What it is called.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Paper => "adaptive, the paper's rule",
            Self::Area => "adaptive, least area",
            Self::Maximum => "adaptive, least maximum",
            Self::Opacity => "opacity map",
            Self::Fourier => "Fourier opacity map",
            Self::Deep => "deep shadow map",
            Self::Moments => "moments",
            Self::Uncompressed => "uncompressed",
        }
    }
}

/// Everything this section says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Curves {
    pub(crate) subjects: Vec<Subject>,
    pub(crate) figures: Vec<Figure>,
}

/// Light rays through one thing.
#[derive(Debug, Clone)]
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) rays: usize,
    /// Segments per ray.
    pub(crate) segments: f64,
    pub(crate) rows: Vec<Row>,
}

/// One kind of curve at one setting.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) family: Family,
    /// Nodes, slices, terms, ε.
    pub(crate) setting: String,
    /// Mean over depths and rays, and the largest, with each of [`RANGES`].
    pub(crate) mean: [f64; RANGES.len()],
    pub(crate) max: [f64; RANGES.len()],
    /// Seconds per segment, and per question, on one thread.
    pub(crate) insertion: Times,
    pub(crate) lookup: Times,
    /// Mean bytes per texel.
    pub(crate) bytes: f64,
}

/// Several curves of one light ray.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    pub(crate) title: String,
    pub(crate) depths: Vec<f64>,
    pub(crate) lines: Vec<Line>,
}

/// Transmittance at the depths of a [`Figure`].
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) name: String,
    /// Colour and marker.
    pub(crate) slot: usize,
    pub(crate) values: Vec<f64>,
}

/// All kinds of curves on the casters of the scene, or else on embedded smoke
/// and hair, and which of the casters no light meets; a quick one looks for less
/// long.
pub(crate) fn judge_all(
    casters: &[Translucent],
    emitters: &[Emitter],
    quick: bool,
) -> Result<(Curves, Vec<LeftOut>), Failure> {
    let bar = progress::bar("curves alone", 3);
    let (mut curves, mut left_out) = (Curves::default(), Vec::new());
    if !casters.is_empty() {
        for caster in casters {
            let one = std::slice::from_ref(caster);
            let name = caster.describe();
            match collect_any(one, emitters, quick)? {
                Ok(rays) => curves.subjects.push(subject(&name, &rays, quick)?),
                Err(why) => left_out.push(LeftOut {
                    what: format!("transmittance alone, {name}"),
                    why: why.into(),
                }),
            }
        }
        if let Ok(rays) = collect_any(casters, emitters, quick)? {
            let title = "A light ray of the scene that meets many blockers";
            let lines = lines_of_all(&rays)?;
            curves.figures.push(figure(title.into(), &rays, lines));
        }
        bar.finish_and_clear();
        return Ok((curves, left_out));
    }
    let sun = |x, y, z| Emitter::directional(Vec3::new(x, y, z), Vec3::ONE);
    let smoke = [thin_smoke()?];
    if let Some(rays) = collect(&smoke, &sun(1.0, -0.2, 0.05)?, quick)? {
        let name = "smoke: three columns of soft puffs, one behind the other";
        curves.subjects.push(subject(name, &rays, quick)?);
        bar.inc(1);
        let title = "Three columns of smoke (figure 7 of the paper)";
        let lines = lines_of_sizes(&rays)?;
        curves.figures.push(figure(title.into(), &rays, lines));
    }
    let hair: [Translucent; 1] = [ponytail(1, 3000, 0.002, 0.6)?.into()];
    if let Some(rays) = collect(&hair, &sun(0.2, -1.0, 0.3)?, quick)? {
        let name = "hair: a ponytail of 3000 strands";
        curves.subjects.push(subject(name, &rays, quick)?);
        bar.inc(1);
    }
    let both = [smoke_grid(1, 1.5)?.into(), hair_in_smoke()?];
    if let Some(rays) = collect(&both, &sun(0.3, -1.0, 0.2)?, quick)? {
        let title = "Smoke and hair (figure 6 of the paper)";
        let lines = lines_of_all(&rays)?;
        curves.figures.insert(0, figure(title.into(), &rays, lines));
    }
    bar.finish_and_clear();
    Ok((curves, left_out))
}

/// The embedded columns of smoke, a third as dense, so that light gets behind
/// the first of them.
fn thin_smoke() -> Result<Translucent, Failure> {
    let smoke = smoke_particles(1);
    let thin = |puff: &Particle| Particle {
        sigma_t: puff.sigma_t / 3.0,
        ..*puff
    };
    let all = smoke.all().iter().map(thin).collect();
    Ok(Particles::new(all, smoke.profile())?.into())
}

/// A ponytail in the unit box, in the middle of the embedded plume.
fn hair_in_smoke() -> Result<Translucent, Failure> {
    let hair = ponytail(1, 1500, 0.002, 0.5)?;
    let point = |point: &StrandPoint| StrandPoint {
        position: Vec3::new(0.5, 0.85, 0.35) + 0.6 * point.position,
        ..*point
    };
    let points: Vec<StrandPoint> = hair.points().iter().map(point).collect();
    let each = points.len() / hair.len();
    let ends = (1..=hair.len()).map(|strand| (strand * each) as u32);
    Ok(Strands::new(points, ends.collect())?.into())
}

/// The light rays of the first light that any of the casters is in the way of,
/// or why there are none.
fn collect_any(
    casters: &[Translucent],
    emitters: &[Emitter],
    quick: bool,
) -> Result<Result<Rays, &'static str>, Failure> {
    for emitter in emitters {
        if let Some(rays) = collect(casters, emitter, quick)? {
            return Ok(Ok(rays));
        }
    }
    Ok(Err(if emitters.is_empty() {
        "the scene has no light"
    } else {
        "it takes nothing from any light that the scene has"
    }))
}

fn collect(
    casters: &[Translucent],
    emitter: &Emitter,
    quick: bool,
) -> Result<Option<Rays>, Failure> {
    let most = if quick { 24 } else { 96 };
    let cpu = Cpu::new();
    let faces = Casters::new(casters, None).faces(&cpu, emitter, rays::RESOLUTION)?;
    // The picture of the light in which most is seen.
    let rays = faces.map(|(_, blockers)| Rays::collect(&blockers, most));
    Ok(rays.flatten().max_by_key(Rays::segments))
}

fn subject(name: &str, rays: &Rays, quick: bool) -> Result<Subject, Failure> {
    let seconds = if quick { 0.006 } else { 0.05 };
    let tight = rays.range();
    let mut rows = Vec::new();
    let mut ranged = Vec::new();
    for looser in RANGES {
        ranged.push(entries(looser, tight)?);
    }
    for (index, entry) in ranged[0].iter().enumerate() {
        let Entry {
            family, setting, ..
        } = entry;
        let mut row = Row {
            family: *family,
            setting: setting.clone(),
            mean: [0.0; RANGES.len()],
            max: [0.0; RANGES.len()],
            insertion: Times::of(&[0.0]),
            lookup: Times::of(&[0.0]),
            bytes: 0.0,
        };
        for (range, entries) in ranged.iter().enumerate() {
            // Only errors depend on the range, and not those of all.
            let judged = if range == 0 || entries[index].knows_range {
                entries[index].judge(rays, if range == 0 { seconds } else { 0.0 })
            } else {
                (row.mean[range], row.max[range]) = (row.mean[0], row.max[0]);
                continue;
            };
            (row.mean[range], row.max[range]) = (judged.mean, judged.max);
            if range == 0 {
                row.insertion = judged.insertion;
                row.lookup = judged.lookup;
                row.bytes = judged.bytes;
            }
        }
        rows.push(row);
    }
    Ok(Subject {
        name: name.into(),
        rays: rays.len(),
        segments: rays.segments() as f64 / rays.len() as f64,
        rows,
    })
}

fn figure(title: String, rays: &Rays, lines: Vec<Line>) -> Figure {
    Figure {
        title,
        depths: rays.plotted_depths().into_iter().map(f64::from).collect(),
        lines,
    }
}

/// `curves.csv`: one line per subject, kind of curve and setting.
pub(crate) fn csv(curves: &Curves) -> String {
    let mut out = "subject,curve,setting,mean,max,seconds_segment,seconds_lookup,bytes,mean_range_4,max_range_4,mean_range_10,max_range_10\n".to_owned();
    for subject in &curves.subjects {
        for row in &subject.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "\"{}\",\"{}\",{},{:e},{:e},{:e},{:e},{},{:e},{:e},{:e},{:e}",
                subject.name.replace('"', "\"\""),
                row.family.title(),
                row.setting,
                row.mean[0],
                row.max[0],
                row.insertion.median,
                row.lookup.median,
                row.bytes,
                row.mean[1],
                row.max[1],
                row.mean[2],
                row.max[2],
            );
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_come_near_the_truth_and_adaptive_ones_need_no_range() {
        let (curves, left_out) = judge_all(&[], &[], true).unwrap();
        assert_eq!(left_out, []);
        assert_eq!((curves.subjects.len(), curves.figures.len()), (2, 2));
        for subject in &curves.subjects {
            assert!(subject.rays > 12 && subject.segments > 30.0);
            let of = |family| {
                let mut rows = subject.rows.iter();
                rows.rfind(|row| row.family == family).unwrap()
            };
            for row in &subject.rows {
                assert!(row.mean.iter().all(|mean| (0.0..1.0).contains(mean)));
                assert!(row.max[0] >= row.mean[0] && row.insertion.median > 0.0);
                assert!(row.lookup.median > 0.0 && row.bytes > 0.0);
            }
            assert!(of(Family::Uncompressed).max[0] < 1e-5);
            assert!(of(Family::Deep).max[0] <= 0.002);
            assert!(of(Family::Area).mean[0] < of(Family::Paper).mean[0]);
            assert_eq!(of(Family::Area).mean[2], of(Family::Area).mean[0]);
            assert!(of(Family::Opacity).mean[2] > 2.0 * of(Family::Opacity).mean[0]);
        }
        for figure in &curves.figures {
            assert!(figure.lines.len() >= 4);
            for line in &figure.lines {
                assert_eq!(line.values.len(), figure.depths.len());
            }
        }
        let csv = csv(&curves);
        let rows: usize = curves
            .subjects
            .iter()
            .map(|subject| subject.rows.len())
            .sum();
        assert_eq!(csv.lines().count(), 1 + rows);
    }

    #[test]
    fn the_first_light_that_meets_casters_counts_and_none_has_a_reason() {
        // Light that runs along strands meets nothing.
        let point = |x: f32, z: f32| StrandPoint {
            position: Vec3::new(x, 0.0, z),
            thickness: 0.5,
            opacity: 0.5,
        };
        let points = (0..4).flat_map(|x| [point(x as f32, 0.0), point(x as f32, 2.0)]);
        let strands = Strands::new(points.collect(), vec![2, 4, 6, 8]).unwrap();
        let strands = [strands.into()];
        let sun = |direction| Emitter::directional(direction, Vec3::ONE).unwrap();
        let (along, across) = (sun(Vec3::NEG_Z), sun(Vec3::NEG_Y));
        let lights = [along.clone(), across];
        let (curves, left_out) = judge_all(&strands, &lights, true).unwrap();
        assert_eq!((curves.subjects.len(), curves.figures.len()), (1, 1));
        assert_eq!(left_out, []);
        for lights in [&[along][..], &[]] {
            let (curves, left_out) = judge_all(&strands, lights, true).unwrap();
            assert!(curves.subjects.is_empty() && curves.figures.is_empty());
            assert_eq!(left_out.len(), 1);
            assert!(left_out[0].what.contains("4 strands"));
            assert!(left_out[0].why.contains("light"), "{}", left_out[0].why);
        }
    }
}
