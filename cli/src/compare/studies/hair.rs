//! Hair that is seen, with every kind of curve as its shadow: error, time and memory.
//!
//! The pictures of Salvi et al., "Adaptive Volumetric Shadow Maps", 2010, with errors,
//! which the paper does not have.

use std::fmt::Debug;
use std::time::Instant;

use gpu_backend::gpu::Gpu;
use gpu_backend::{Cpu, Download, Host};
use lighting::Emitter;
use lighting::hair::{AddHairLight, Fibre, HairMemory, LitHair, SeenHair};
use lighting::scene::view::View;
use lighting::scene::{Media, Translucent};
use lighting::translucent::{Casters, TransmittanceMap};
use transmittance::baseline::{Captured, Uncompressed};
use transmittance::{Accumulate, CurveMap, Evaluate, Packed, Stream};

use super::curves::kinds::{Named, Visit, named, range, visit_all};
use super::curves::show::series_of_kinds;
use super::curves::{Family, collect_any};
use super::{Device, Kind, Limit, Subject};
use crate::compare::study::{Axis, Cell, Chart, Charts, Column, Part, Point, Scale, Study, Unit};
use crate::failure::Failure;
use crate::format::{bytes, seconds, significant};
use crate::hair::{light_of, triangles_in_shaders};
use crate::progress;

pub(super) const KIND: Kind = Kind {
    title: "hair",
    csv: "hair.csv",
    columns,
    seconds: Some([3.0, 30.0]),
    in_fog: false,
    pointless,
    run,
};

/// The range of depths that methods are given is this many times as long as that of the blockers
/// of some rays, so that it holds the blockers of all rays.
const LOOSER: f64 = 1.5;

/// A kind of curves and its picture.
#[derive(Debug)]
struct Row {
    /// Where the hair is lit; maps are made on the CPU.
    backend: String,
    name: Named,
    /// Differences from the picture of uncompressed curves, root mean square and the largest,
    /// over the mean of that picture where there is hair.
    error: f64,
    worst: f64,
    /// Seconds for the map, and for the light of the hair.
    map: f64,
    light: f64,
    /// Mean bytes of a texel of the map.
    bytes: f64,
}

fn is_hair(caster: &&Translucent) -> bool {
    matches!(caster, Translucent::Strands(_))
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    let none = !subject.translucent.iter().any(|caster| is_hair(&caster));
    none.then_some("the scene has no hair")
}

fn columns() -> Vec<Column> {
    vec![
        Column::plain("backend"),
        Column::plain("curve"),
        Column::plain("setting"),
        Column::new("error", Unit::Share),
        Column::new("worst", Unit::Share),
        Column::new("seconds_map", Unit::Seconds),
        Column::new("seconds_light", Unit::Seconds),
        Column::new("bytes", Unit::Bytes),
    ]
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    if let Some(why) = limit.reached() {
        study.leave_out("all hair", why);
        return Ok(study);
    }
    let hair: Vec<Translucent> = subject
        .translucent
        .iter()
        .filter(is_hair)
        .cloned()
        .collect();
    let (emitter, rays) = match collect_any(&hair, subject.emitters, subject.quick)? {
        Ok(found) => found,
        Err(why) => {
            study.leave_out("all hair", why);
            return Ok(study);
        }
    };
    let cpu = Cpu::new();
    let [width, height] = [subject.size.width, subject.size.height];
    let view = View::new(&cpu, subject.camera, subject.tracer, width, height)?;
    let Some(seen) = SeenHair::new(&cpu, subject.camera, &view, subject.translucent) else {
        study.leave_out("all hair", "none is in view");
        return Ok(study);
    };
    let casters = Casters::new(subject.translucent, None);
    let media = Media::new(Some(subject.medium), None, subject.translucent);
    let stand = Stand {
        side: casters.resolution(subject.map, subject.emitters, emitter),
        cpu,
        casters,
        media,
        view,
        seen,
        emitter,
        subject,
    };
    let bar = progress::spinner("hair");
    let clock = Instant::now();
    let truth = stand.truth()?;
    let Some(truth) = truth else {
        bar.finish_and_clear();
        study.leave_out("all hair", "no light reaches what is in view");
        return Ok(study);
    };
    let mut pictures = Pictures {
        stand: &stand,
        truth: &truth,
        limit,
        each: clock.elapsed().as_secs_f64(),
        rows: Vec::new(),
        study: &mut study,
        failed: Ok(()),
    };
    visit_all(range(LOOSER, rays.range())?, &mut pictures)?;
    for device in &subject.devices {
        if let Err(failure) = pictures.on_gpu(device) {
            // The pictures of the CPU stay in the report.
            let what = light_on(device);
            pictures.study.leave_out(&what, failure.to_string());
        }
    }
    pictures.failed?;
    let rows = pictures.rows;
    bar.finish_and_clear();
    describe(&mut study, &rows, stand.side);
    Ok(study)
}

/// Hair in front of a camera.
struct Stand<'a> {
    cpu: Cpu,
    casters: Casters<'a>,
    media: Media<'a>,
    view: View,
    seen: SeenHair,
    emitter: &'a Emitter,
    subject: &'a Subject<'a>,
    /// Texels per side of its maps.
    side: u32,
}

/// The picture with uncompressed curves, and its brightness.
struct Truth {
    picture: Vec<[f32; 4]>,
    /// Mean radiance of the pixels with hair that is lit.
    mean: f64,
    pixels: usize,
}

impl Stand<'_> {
    fn map<A, T>(&self, clear: &A) -> Result<TransmittanceMap<Host, T>, Failure>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Into<T>,
        T: Evaluate + Debug + Send,
    {
        let (cpu, casters) = (&self.cpu, &self.casters);
        Ok(TransmittanceMap::build(
            cpu,
            casters,
            self.emitter,
            self.side,
            clear,
        )?)
    }

    /// The light of the hair on a backend that has the triangles and the map.
    fn light<B, T>(
        &self,
        backend: &B,
        tracer: &<B::Memory as HairMemory<T>>::Tracer,
        map: &TransmittanceMap<B::Memory, T>,
    ) -> Result<Vec<[f32; 4]>, Failure>
    where
        B: AddHairLight<T> + Download,
    {
        let lit = LitHair {
            view: &self.view,
            translucent: self.subject.translucent,
            media: &self.media,
            tracer,
            lights: &[(self.emitter, map)],
            fibre: Fibre::default(),
        };
        light_of(backend, &self.seen, &lit)
    }

    fn light_here<T>(&self, map: &TransmittanceMap<Host, T>) -> Result<Vec<[f32; 4]>, Failure>
    where
        T: Evaluate + Debug + Sync,
    {
        self.light(&self.cpu, self.subject.tracer, map)
    }

    /// `None` if all is dark.
    fn truth(&self) -> Result<Option<Truth>, Failure> {
        let picture = self.light_here(&self.map::<_, Uncompressed>(&Captured::new())?)?;
        let lit = picture.iter().map(brightness).filter(|light| *light > 0.0);
        let (sum, pixels) = lit.fold((0.0, 0), |(sum, count), light| (sum + light, count + 1));
        Ok((pixels > 0).then(|| Truth {
            picture,
            mean: sum / pixels as f64,
            pixels,
        }))
    }
}

fn brightness(pixel: &[f32; 4]) -> f64 {
    pixel[..3]
        .iter()
        .map(|light| f64::from(*light))
        .sum::<f64>()
        / 3.0
}

/// Makes a picture with each kind of curves.
struct Pictures<'a> {
    stand: &'a Stand<'a>,
    truth: &'a Truth,
    limit: &'a Limit<'a>,
    /// Seconds that the last took.
    each: f64,
    rows: Vec<Row>,
    study: &'a mut Study,
    failed: Result<(), Failure>,
}

impl Pictures<'_> {
    fn row<A, T>(&self, name: Named, clear: &A, bytes: impl Fn(&T) -> usize) -> Result<Row, Failure>
    where
        A: Accumulate + Clone + Sync,
        A::Curve: Into<T>,
        T: Evaluate + Debug + Send + Sync,
    {
        let clock = Instant::now();
        let map = self.stand.map::<A, T>(clear)?;
        let made = clock.elapsed().as_secs_f64();
        let picture = self.stand.light_here(&map)?;
        let light = clock.elapsed().as_secs_f64() - made;
        let bytes = mean_bytes(&map, bytes);
        Ok(self.of("cpu", name, [made, light], bytes, &picture))
    }

    /// The row of a picture that took so many seconds for the map and for the light.
    fn of(
        &self,
        backend: &str,
        name: Named,
        [map, light]: [f64; 2],
        bytes: f64,
        picture: &[[f32; 4]],
    ) -> Row {
        let (mut squares, mut worst) = (0.0, 0.0_f64);
        for (found, truth) in picture.iter().zip(&self.truth.picture) {
            let off = (brightness(found) - brightness(truth)).abs();
            (squares, worst) = (squares + off * off, worst.max(off));
        }
        Row {
            backend: backend.into(),
            name,
            error: (squares / self.truth.pixels as f64).sqrt() / self.truth.mean,
            worst: worst / self.truth.mean,
            map,
            light,
            bytes,
        }
    }

    /// Lights the hair on a GPU, by the curves that a picture takes unless others are asked for.
    fn on_gpu(&mut self, device: &Device<'_>) -> Result<(), Failure> {
        let Some(context) = device.context else {
            return Ok(());
        };
        let what = light_on(device);
        if let Some(why) = self.limit.reached_after(2.0 * self.each) {
            self.study.leave_out(&what, why);
            return Ok(());
        }
        let Stand { subject, .. } = self.stand;
        let gpu = Gpu::new(context.clone());
        let tracer = match triangles_in_shaders(&gpu, subject.geometry, subject.tracer)? {
            Ok(tracer) => tracer,
            Err(why) => {
                self.study.leave_out(&what, why);
                return Ok(());
            }
        };
        let clock = Instant::now();
        let map = self.stand.map::<_, Packed<8>>(&Stream::<8>::new())?;
        let made = clock.elapsed().as_secs_f64();
        let there = map.upload(&gpu)?;
        // The first picture compiles the shaders.
        self.stand.light(&gpu, &tracer, &there)?;
        let clock = Instant::now();
        let picture = self.stand.light(&gpu, &tracer, &there)?;
        let light = clock.elapsed().as_secs_f64();
        let bytes = mean_bytes(&map, |_| size_of::<Packed<8>>());
        let name = named(Family::Area, 8);
        let row = self.of(&device.short, name, [made, light], bytes, &picture);
        self.rows.push(row);
        Ok(())
    }
}

/// The name of what is left out where a device does not light hair.
fn light_on(device: &Device<'_>) -> String {
    format!("light on {}", device.label)
}

/// Mean bytes of a texel of a map whose curves take so many `bytes`.
fn mean_bytes<T: Debug>(map: &TransmittanceMap<Host, T>, bytes: impl Fn(&T) -> usize) -> f64 {
    let curves = map.curves().iter().flat_map(CurveMap::texels);
    let (total, count) = curves.fold((0, 0), |(total, count), curve| {
        (total + bytes(curve), count + 1)
    });
    total as f64 / f64::from(count.max(1))
}

impl Visit for Pictures<'_> {
    fn kind<A, T>(&mut self, name: Named, clear: A, bytes: impl Fn(&T) -> usize + 'static)
    where
        A: Accumulate + Clone + Sync + 'static,
        A::Curve: Into<T>,
        T: Evaluate + Debug + Send + Sync + 'static,
    {
        if self.failed.is_err() {
            return;
        }
        if let Some(why) = self.limit.reached_after(self.each) {
            let what = format!("{}, {}", name.family.title(), name.setting);
            self.study.leave_out(&what, why);
            return;
        }
        match self.row(name, &clear, bytes) {
            Ok(row) => {
                self.each = row.map + row.light;
                self.rows.push(row);
            }
            Err(failure) => self.failed = Err(failure),
        }
    }
}

/// Puts the measurements into words, a chart and a table.
fn describe(study: &mut Study, rows: &[Row], side: u32) {
    if rows.is_empty() {
        return;
    }
    study.introduction = format!(
        "The light that hair scatters to the eye, shadowed by hair and smoke through a map of {side} texels per side \
with every kind of curve, for the first light that meets hair. Errors are differences of brightness from \
the picture with uncompressed curves of the same map, over the mean brightness of hair that is lit; \
what a finer map would show is not counted. Times are those of the map, which is made on the CPU, and of \
the light of the picture, on all threads, taken once."
    );
    for row in rows {
        let cells: [Cell; 8] = [
            row.backend.as_str().into(),
            Cell::keyed(row.name.family.title(), row.name.family.key()),
            row.name.setting.as_str().into(),
            row.error.into(),
            row.worst.into(),
            row.map.into(),
            row.light.into(),
            row.bytes.into(),
        ];
        study.records.push(cells.into());
    }
    let headings = [
        ("backend", "light on"),
        ("curve", "curve"),
        ("setting", "setting"),
        ("error", "error"),
        ("worst", "worst pixel"),
        ("seconds_map", "map"),
        ("seconds_light", "light"),
        ("bytes", "per texel"),
    ];
    study.parts.push(Part::Charts(Charts {
        share_legend: false,
        all: vec![chart(rows)],
    }));
    let mut table = study.records.view(&headings, |_| true);
    table.grouped = true;
    study.parts.push(Part::Table(table));
}

/// Error against memory.
fn chart(rows: &[Row]) -> Chart {
    let point = |row: &Row| Point {
        x: row.bytes,
        y: row.error,
        spread: [row.bytes; 2],
        label: row.name.setting.clone(),
        title: format!(
            "{}, {}: error {}, {} per texel, {} for the map and {} for the light",
            row.name.family.title(),
            row.name.setting,
            significant(row.error),
            bytes(row.bytes.round() as u64),
            seconds(row.map),
            seconds(row.light),
        ),
    };
    let points = |family: Family| {
        // Pictures of a GPU are the same but for roundings.
        let own = rows
            .iter()
            .filter(|row| row.name.family == family && row.backend == "cpu");
        own.map(point).collect()
    };
    Chart {
        title: "hair".into(),
        caption: "error against the memory of a texel".into(),
        description: "error of the light of hair against the memory of a texel, both logarithmic"
            .into(),
        x: Axis {
            label: "memory of a texel".into(),
            scale: Scale::Log,
            unit: Unit::Bytes,
        },
        y: Axis {
            label: "error".into(),
            scale: Scale::Log,
            unit: Unit::Share,
        },
        front: true,
        series: series_of_kinds(points),
    }
}

#[cfg(test)]
mod tests {
    use lighting::scene::procedural::Embedded;

    use super::super::tests::Stand;
    use super::*;
    use crate::compare::study::Value;

    #[test]
    fn adaptive_curves_come_close_to_uncompressed_ones_and_more_nodes_closer() {
        let stand = Stand::of(Embedded::SmokeHair);
        let mut subject = stand.subject();
        subject.size.width = 48;
        subject.size.height = 27;
        let study = run(&subject, &Limit::of(f64::INFINITY)).unwrap();
        assert_eq!(study.left_out, []);
        let error = |family: Family, setting: &str| {
            let own = |row: &&crate::compare::study::Row| {
                row.cells[1].text() == Some(family.title()) && row.cells[2].text() == Some(setting)
            };
            let row = study.records.rows().iter().find(own).unwrap();
            match row.cells[3].value {
                Value::Number(error) => error,
                _ => panic!("a number: {row:?}"),
            }
        };
        assert_eq!(error(Family::Uncompressed, "all"), 0.0);
        let [four, sixteen] = ["4", "16"].map(|nodes| error(Family::Area, nodes));
        assert!(sixteen < 0.5 * four && four < 0.2, "{four} {sixteen}");
        assert!(sixteen < error(Family::Opacity, "32"));
    }

    #[test]
    fn nothing_is_begun_when_the_time_is_over() {
        let stand = Stand::of(Embedded::SmokeHair);
        let study = run(&stand.subject(), &Limit::of(0.0)).unwrap();
        assert!(study.parts.is_empty() && study.records.rows().is_empty());
        assert_eq!(study.left_out.len(), 1);
    }

    #[test]
    fn a_scene_without_hair_has_a_reason() {
        let stand = Stand::of(Embedded::City);
        assert_eq!(pointless(&stand.subject()), Some("the scene has no hair"));
    }
}
