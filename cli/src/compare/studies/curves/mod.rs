//! Curves of transmittance without a picture: error, time and memory of every
//! kind on the light rays of hair and smoke.
//!
//! Table 1 and figures 6 and 7 of Salvi et al., "Adaptive Volumetric Shadow
//! Maps", 2010, with errors, which the paper does not have.

mod entries;
pub(super) mod kinds;
mod rays;
pub(super) mod show;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::scene::procedural::{ponytail, smoke_grid, smoke_particles};
use lighting::scene::{Particle, Particles, StrandPoint, Strands, Translucent};
use lighting::translucent::Casters;

use super::{Kind, Limit, Subject};
use crate::compare::study::{Column, Key, Study, Unit};
use crate::compare::times::Times;
use crate::failure::Failure;
use crate::progress;
use entries::{Entry, entries, lines_of_all, lines_of_sizes};
use rays::Rays;
use show::describe;

pub(super) const KIND: Kind = Kind {
    title: "curves of transmittance",
    csv: "curves.csv",
    columns,
    seconds: None,
    in_fog: false,
    pointless,
    run,
};

/// The ranges of depths that methods are given are these many times as long as that of the
/// blockers; the first is the tight one.
const RANGES: [f64; 3] = [1.0, 4.0, 10.0];

/// A kind of curve, in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
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
    pub(super) const ALL: [Self; 8] = [
        Self::Paper,
        Self::Area,
        Self::Maximum,
        Self::Opacity,
        Self::Fourier,
        Self::Deep,
        Self::Moments,
        Self::Uncompressed,
    ];

    /// Its name in the report.
    pub(super) fn title(self) -> &'static str {
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

    /// Its colour and marker; the first of all is that of the truth.
    pub(super) fn key(self) -> Key {
        let place = Self::ALL.into_iter().position(|other| other == self);
        Key::new(1 + place.unwrap_or(0))
    }
}

/// Light rays through one thing, and every kind of curve on them.
#[derive(Debug)]
struct Specimen {
    name: String,
    rays: usize,
    /// Segments per ray.
    segments: f64,
    rows: Vec<Row>,
}

/// One kind of curve at one setting.
#[derive(Debug)]
struct Row {
    family: Family,
    /// Nodes, slices, terms, ε.
    setting: String,
    /// Mean over depths and rays, and the largest, with each of [`RANGES`].
    mean: [f64; RANGES.len()],
    max: [f64; RANGES.len()],
    /// Seconds per segment, and per lookup, on one thread.
    insertion: Times,
    lookup: Times,
    /// Mean bytes per texel.
    bytes: f64,
}

/// Several curves of one light ray.
#[derive(Debug)]
struct Figure {
    title: String,
    depths: Vec<f64>,
    lines: Vec<Line>,
}

/// Transmittance at the depths of a [`Figure`].
#[derive(Debug)]
struct Line {
    name: String,
    key: Key,
    values: Vec<f64>,
}

/// Everything that there is to show.
#[derive(Debug, Default)]
struct Found {
    specimens: Vec<Specimen>,
    figures: Vec<Figure>,
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    let none = subject.translucent.is_empty();
    none.then_some("nothing in the scene is translucent")
}

fn columns() -> Vec<Column> {
    vec![
        Column::plain("subject"),
        Column::plain("curve"),
        Column::plain("setting"),
        Column::new("mean", Unit::Number),
        Column::new("max", Unit::Number),
        Column::new("seconds_segment", Unit::Seconds),
        Column::new("seconds_lookup", Unit::Seconds),
        Column::new("bytes", Unit::Bytes),
        Column::new("mean_range_4", Unit::Number),
        Column::new("max_range_4", Unit::Number),
        Column::new("mean_range_10", Unit::Number),
        Column::new("max_range_10", Unit::Number),
    ]
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let found = measure_all(&mut study, subject, limit)?;
    describe(&mut study, &found);
    Ok(study)
}

/// All kinds of curves on the casters of the scene, and unless the study is to be quick, on the
/// smoke and hair of the paper's figures.
fn measure_all(
    study: &mut Study,
    subject: &Subject<'_>,
    limit: &Limit<'_>,
) -> Result<Found, Failure> {
    let mut found = Found::default();
    scene_casters(study, subject, limit, &mut found)?;
    if !subject.quick {
        published(study, limit, false, &mut found)?;
    }
    Ok(found)
}

/// All kinds of curves on embedded smoke and hair.
fn published(
    study: &mut Study,
    limit: &Limit<'_>,
    quick: bool,
    found: &mut Found,
) -> Result<(), Failure> {
    let bar = progress::bar("curves of transmittance", 3);
    for measure in [columns_of_smoke as Measure, one_ponytail, hair_in_a_plume] {
        if let Some(why) = limit.reached() {
            study.leave_out("the embedded smoke and hair", why);
            break;
        }
        measure(quick, found)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// Adds the measurements on more casters, in a quick way or not.
type Measure = fn(bool, &mut Found) -> Result<(), Failure>;

fn scene_casters(
    study: &mut Study,
    subject: &Subject<'_>,
    limit: &Limit<'_>,
    found: &mut Found,
) -> Result<(), Failure> {
    let (casters, quick) = (subject.translucent, subject.quick);
    for caster in casters {
        let one = std::slice::from_ref(caster);
        let name = unlike(&found.specimens, caster.describe());
        if let Some(why) = limit.reached() {
            study.leave_out(&name, why);
            continue;
        }
        match collect_any(one, subject.emitters, quick)? {
            Ok((_, rays)) => found.specimens.push(specimen(&name, &rays, quick)?),
            Err(why) => study.leave_out(&name, why),
        }
    }
    if let Ok((_, rays)) = collect_any(casters, subject.emitters, quick)? {
        let title = "A light ray of the scene that meets many blockers";
        let lines = lines_of_all(&rays)?;
        found.figures.push(figure(title.into(), &rays, lines));
    }
    Ok(())
}

fn columns_of_smoke(quick: bool, found: &mut Found) -> Result<(), Failure> {
    let sun = Emitter::directional(Vec3::new(1.0, -0.2, 0.05), Vec3::ONE)?;
    if let Some(rays) = collect(&[thin_smoke()?], &sun, quick)? {
        let name = "smoke: three columns of soft puffs, one behind the other";
        found.specimens.push(specimen(name, &rays, quick)?);
        let title = "Three columns of smoke (figure 7 of the paper)";
        let lines = lines_of_sizes(&rays)?;
        found.figures.push(figure(title.into(), &rays, lines));
    }
    Ok(())
}

fn one_ponytail(quick: bool, found: &mut Found) -> Result<(), Failure> {
    let sun = Emitter::directional(Vec3::new(0.2, -1.0, 0.3), Vec3::ONE)?;
    let hair: [Translucent; 1] = [ponytail(1, 3000, 0.002, 0.6)?.into()];
    if let Some(rays) = collect(&hair, &sun, quick)? {
        let name = "hair: a ponytail of 3000 strands";
        found.specimens.push(specimen(name, &rays, quick)?);
    }
    Ok(())
}

fn hair_in_a_plume(quick: bool, found: &mut Found) -> Result<(), Failure> {
    let sun = Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE)?;
    let both = [smoke_grid(1, 1.5)?.into(), hair_in_smoke()?];
    if let Some(rays) = collect(&both, &sun, quick)? {
        let title = "Smoke and hair (figure 6 of the paper)";
        let lines = lines_of_all(&rays)?;
        found.figures.push(figure(title.into(), &rays, lines));
    }
    Ok(())
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

/// The first light whose way is blocked by any of the casters, and its rays through them, or why
/// there is none.
pub(super) fn collect_any<'e>(
    casters: &[Translucent],
    emitters: &'e [Emitter],
    quick: bool,
) -> Result<Result<(&'e Emitter, Rays), &'static str>, Failure> {
    for emitter in emitters {
        if let Some(rays) = collect(casters, emitter, quick)? {
            return Ok(Ok((emitter, rays)));
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

/// A name that no specimen has: alike ones are numbered.
fn unlike(specimens: &[Specimen], name: String) -> String {
    let is_free = |name: &String| specimens.iter().all(|known| known.name != *name);
    let mut numbered = (2..).map(|number| format!("{name}, number {number}"));
    match is_free(&name) {
        true => name,
        false => numbered.find(is_free).unwrap_or(name),
    }
}

fn specimen(name: &str, rays: &Rays, quick: bool) -> Result<Specimen, Failure> {
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
            // Only the errors depend on the range, and only for some kinds.
            let measured = if range == 0 || entries[index].knows_range {
                entries[index].measure(rays, if range == 0 { seconds } else { 0.0 })
            } else {
                (row.mean[range], row.max[range]) = (row.mean[0], row.max[0]);
                continue;
            };
            (row.mean[range], row.max[range]) = (measured.mean, measured.max);
            if range == 0 {
                row.insertion = measured.insertion;
                row.lookup = measured.lookup;
                row.bytes = measured.bytes;
            }
        }
        rows.push(row);
    }
    Ok(Specimen {
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

#[cfg(test)]
mod tests {
    use super::*;

    use super::super::tests::Stand;
    use crate::compare::study::Part;
    use lighting::scene::procedural::Embedded;

    /// What is found on these casters in this light.
    fn find(casters: &[Translucent], emitters: &[Emitter]) -> (Found, Study) {
        let stand = Stand::of(Embedded::City);
        let mut subject = stand.subject();
        (subject.translucent, subject.emitters) = (casters, emitters);
        let mut study = KIND.blank();
        let found = measure_all(&mut study, &subject, &Limit::of(f64::INFINITY)).unwrap();
        (found, study)
    }

    #[test]
    fn curves_come_near_the_truth_and_adaptive_ones_need_no_range() {
        let (mut found, mut study) = (Found::default(), KIND.blank());
        published(&mut study, &Limit::of(f64::INFINITY), true, &mut found).unwrap();
        assert_eq!(study.left_out, []);
        assert_eq!((found.specimens.len(), found.figures.len()), (2, 2));
        for specimen in &found.specimens {
            assert!(specimen.rays > 12 && specimen.segments > 30.0);
            let of = |family| {
                let mut rows = specimen.rows.iter();
                rows.rfind(|row| row.family == family).unwrap()
            };
            for row in &specimen.rows {
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
        for figure in &found.figures {
            assert!(figure.lines.len() >= 4);
            for line in &figure.lines {
                assert_eq!(line.values.len(), figure.depths.len());
            }
        }
        describe(&mut study, &found);
        let rows: usize = found
            .specimens
            .iter()
            .map(|specimen| specimen.rows.len())
            .sum();
        assert_eq!(study.records.rows().len(), rows);
        // Charts, a table for each specimen, and the figures.
        assert_eq!(study.parts.len(), 4);
        for (part, specimen) in study.parts[1..3].iter().zip(&found.specimens) {
            let Part::Table(table) = part else {
                panic!("a table: {part:?}");
            };
            assert_eq!(table.rows().len(), specimen.rows.len());
        }
    }

    #[test]
    fn names_of_columns_have_the_ranges_that_are_measured() {
        let names: Vec<String> = columns().into_iter().map(|column| column.name).collect();
        for range in &RANGES[1..] {
            assert!(names.contains(&format!("mean_range_{range}")), "{names:?}");
        }
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
        let (found, study) = find(&strands, &lights);
        assert_eq!((found.specimens.len(), found.figures.len()), (1, 1));
        assert_eq!(study.left_out, []);
        for lights in [&[along][..], &[]] {
            let (found, mut study) = find(&strands, lights);
            assert!(found.specimens.is_empty() && found.figures.is_empty());
            assert_eq!(study.left_out.len(), 1);
            assert!(study.left_out[0].what.contains("4 strands"));
            let why = &study.left_out[0].why;
            assert!(why.contains("light"), "{why}");
            describe(&mut study, &found);
            assert!(study.parts.is_empty());
        }
    }
}
