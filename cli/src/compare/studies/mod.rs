//! Studies, each of which measures one algorithm by itself, beside the methods: one file or
//! folder per study, and the one list of them.
//!
//! A study is a [`Kind`]: its heading, the name and the columns of its CSV file,
//! why it may have nothing to say about a scene, and the function that carries
//! it out. That function is given a [`Subject`] and a [`Limit`], and returns a
//! [`Study`], which is plain data. Neither this module nor [`crate::report`]
//! knows any study by name; to add one, write its file and add its line to
//! [`STUDIES`].

mod area_lights;
mod curves;
mod evaluators;
mod hair;
mod many_lights;
mod marching;
mod precomputed_shadows;
mod shadowed_lights;
mod voxel_grids;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use gpu_backend::gpu::Context;
use lighting::scene::trace::{Hit, Tracer};
use lighting::scene::{AreaEmitters, Camera, Geometry, Medium, Translucent};
use lighting::{Emitter, Ray};

use super::budget::Budget;
use super::study::{Cell, Column, NO_TIME, Study, Unit};
use crate::failure::Failure;
use crate::parse::Size;
use crate::suggest::question;

/// All studies, in the order in which they are carried out and reported.
pub(crate) const STUDIES: [Kind; 9] = [
    evaluators::KIND,
    voxel_grids::KIND,
    area_lights::KIND,
    curves::KIND,
    hair::KIND,
    precomputed_shadows::KIND,
    marching::KIND,
    many_lights::KIND,
    shadowed_lights::KIND,
];

/// What asks for no study, in place of names.
const NO_STUDY: &str = "none";

/// One study, before it is carried out.
pub(crate) struct Kind {
    /// Its heading.
    pub(crate) title: &'static str,
    /// Name of its CSV file.
    pub(crate) csv: &'static str,
    /// The columns of that file.
    pub(crate) columns: fn() -> Vec<Column>,
    /// Seconds that it may take, in a quick comparison and in a full one, unless everything is to
    /// be measured. A study that is short by nature has no such limit: it runs however little
    /// time is left, so that its results do not depend on the machine.
    pub(crate) seconds: Option<[f64; 2]>,
    /// Whether it measures light in the homogeneous medium of the scene.
    pub(crate) in_fog: bool,
    /// The reason why there is nothing to measure in a scene, if so.
    pub(crate) pointless: fn(&Subject<'_>) -> Option<&'static str>,
    pub(crate) run: fn(&Subject<'_>, &Limit<'_>) -> Result<Study, Failure>,
}

impl Kind {
    /// Its name on the command line: that of its file.
    pub(crate) fn name(&self) -> &'static str {
        self.csv.trim_end_matches(".csv")
    }

    /// The study before anything is measured.
    pub(crate) fn blank(&self) -> Study {
        Study::new(self.title, self.csv, (self.columns)())
    }

    fn limit<'a>(&self, quick: bool, budget: Budget, stop: &'a AtomicBool) -> Limit<'a> {
        let is_limited = budget.total().is_finite();
        let seconds = match self.seconds.filter(|_| is_limited) {
            Some(seconds) => seconds[usize::from(!quick)].min(budget.left()),
            None => f64::INFINITY,
        };
        Limit {
            clock: Instant::now(),
            seconds,
            budget,
            stop,
        }
    }
}

/// The scene and the picture on which studies measure.
pub(crate) struct Subject<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) tracer: &'a Tracer,
    pub(crate) medium: &'a Medium,
    pub(crate) translucent: &'a [Translucent],
    /// Lights that reach the view, as far as the plan keeps them.
    pub(crate) emitters: &'a [Emitter],
    /// The area lights among them.
    pub(crate) areas: &'a [AreaEmitters],
    pub(crate) camera: &'a Camera,
    /// The rays of the picture, and its size.
    pub(crate) rays: &'a [Ray],
    /// The surface on which each ray ends.
    pub(crate) hits: &'a [Option<Hit>],
    pub(crate) size: Size,
    /// Texels per side of a shadow map.
    pub(crate) map: u32,
    pub(crate) devices: Vec<Device<'a>>,
    /// Asks for few settings and short measurements.
    pub(crate) quick: bool,
}

impl Subject<'_> {
    /// A sentence for studies whose bakes take every triangle.
    fn dynamic_baked(&self) -> &'static str {
        match self.geometry.dynamic_part() {
            Some(_) => " What is dynamic is baked like the rest here.",
            None => "",
        }
    }
}

/// A backend to measure on.
pub(crate) struct Device<'a> {
    /// Its full name.
    pub(crate) label: String,
    /// Its name where there is little space.
    pub(crate) short: String,
    /// `None` is the CPU.
    pub(crate) context: Option<&'a Context>,
}

/// How long a study may go on.
pub(crate) struct Limit<'a> {
    clock: Instant,
    /// Seconds for this study.
    seconds: f64,
    /// The time of the whole comparison.
    budget: Budget,
    /// Set when the user interrupts the program.
    stop: &'a AtomicBool,
}

impl Limit<'_> {
    /// Seconds for this study; infinite if it is short by nature.
    pub(crate) fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Seconds since it began.
    pub(crate) fn elapsed(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    /// The reason to begin nothing more, if there is one: its own time is over, or the user has
    /// interrupted it.
    pub(crate) fn reached(&self) -> Option<&'static str> {
        self.reached_after(0.0)
    }

    /// The reason not to begin something that takes about `seconds`, if there is one.
    pub(crate) fn reached_after(&self, seconds: f64) -> Option<&'static str> {
        let over = self.seconds.is_finite() && self.elapsed() + seconds >= self.seconds;
        self.interrupted().or(over.then_some(NO_TIME))
    }

    /// The reason to begin nothing at all, if there is one: the time of the whole comparison is
    /// over, which may be later than that of the study, or the user has interrupted it.
    pub(crate) fn budget_reached(&self) -> Option<&'static str> {
        let over = self.budget.left() <= 0.0;
        self.interrupted().or(over.then_some(NO_TIME))
    }

    /// The flag that is set when the user interrupts the program.
    pub(crate) fn stop(&self) -> &AtomicBool {
        self.stop
    }

    fn interrupted(&self) -> Option<&'static str> {
        self.stop.load(Ordering::Relaxed).then_some("interrupted")
    }
}

/// The columns of records that are single numbers; see [`record`].
fn value_columns() -> Vec<Column> {
    vec![
        Column::plain("what"),
        Column::plain("of"),
        Column::plain("size"),
        Column::new("value", Unit::Number),
    ]
}

/// Adds one number to records with [`value_columns`].
fn record(study: &mut Study, what: &str, of: &str, size: u32, value: f64) {
    let cells: [Cell; 4] = [what.into(), of.into(), size.into(), value.into()];
    study.records.push(cells.into());
}

/// Which studies the user asked for (`--studies`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Asked<'a> {
    All,
    /// Those with these names; there may be none.
    Some(&'a [String]),
}

impl<'a> Asked<'a> {
    /// Reads the names; no name at all asks for every study. Returns an error if there is no
    /// study of a name.
    pub(crate) fn new(names: &'a [String]) -> Result<Self, Failure> {
        match names {
            [] => Ok(Self::All),
            [name] if name == NO_STUDY => Ok(Self::Some(&[])),
            _ => {
                let known: Vec<_> = STUDIES.iter().map(Kind::name).collect();
                match names.iter().find(|name| !known.contains(&name.as_str())) {
                    None => Ok(Self::Some(names)),
                    Some(name) => Err(Failure::new(format!(
                        "no study is called \"{name}\"{}; there are {}, or \"{NO_STUDY}\" by \
                         itself",
                        question(name, &known),
                        known.join(", ")
                    ))),
                }
            }
        }
    }

    fn includes(&self, kind: &Kind) -> bool {
        match self {
            Self::All => true,
            Self::Some(names) => names.iter().any(|name| name == kind.name()),
        }
    }
}

/// Carries out the studies that were `asked` for, one after the other. One that was not, one
/// that is pointless, or for which the scene leaves no time, is there without parts.
pub(crate) fn run_all(
    asked: &Asked<'_>,
    subject: &Subject<'_>,
    budget: Budget,
    stop: &AtomicBool,
) -> Result<Vec<Study>, Failure> {
    let run = |kind: &Kind| {
        let unasked = (!asked.includes(kind)).then_some("not asked for (--studies)");
        let is_clear = kind.in_fog && subject.medium.scatters_nothing();
        let clear = is_clear.then_some("no homogeneous medium scatters light");
        let pointless = || (kind.pointless)(subject);
        if let Some(why) = unasked.or(clear).or_else(pointless) {
            let mut study = kind.blank();
            study.leave_out("", why);
            return Ok(study);
        }
        (kind.run)(subject, &kind.limit(subject.quick, budget, stop))
    };
    STUDIES.iter().map(run).collect()
}

/// Every study before anything is measured, for a comparison of nothing.
pub(crate) fn all_blank() -> Vec<Study> {
    STUDIES.iter().map(Kind::blank).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use lighting::scene::Scene;
    use lighting::scene::procedural::Embedded;

    use super::*;

    /// A scene with what is made from it.
    pub(super) struct Stand {
        pub(super) scene: Scene,
        pub(super) geometry: Geometry,
        pub(super) tracer: Tracer,
        pub(super) emitters: Vec<Emitter>,
        pub(super) camera: Camera,
    }

    impl Stand {
        pub(super) fn of(embedded: Embedded) -> Self {
            let mut scene = embedded.build(1);
            let geometry = Geometry::new(&scene).unwrap();
            scene.complete(geometry.bounds()).unwrap();
            Self {
                tracer: Tracer::new(&geometry),
                emitters: scene.lights[0].emitters(1).unwrap(),
                camera: scene.camera.unwrap(),
                geometry,
                scene,
            }
        }

        /// A quick look at it without rays and backends.
        pub(super) fn subject(&self) -> Subject<'_> {
            Subject {
                geometry: &self.geometry,
                tracer: &self.tracer,
                medium: self.scene.medium.as_ref().unwrap(),
                translucent: &self.scene.translucent,
                emitters: &self.emitters,
                areas: &[],
                camera: &self.camera,
                rays: &[],
                hits: &[],
                size: Size {
                    width: 16,
                    height: 9,
                },
                map: 128,
                devices: Vec::new(),
                quick: true,
            }
        }
    }

    static NEVER: AtomicBool = AtomicBool::new(false);
    static ALREADY: AtomicBool = AtomicBool::new(true);

    impl Limit<'_> {
        /// A limit of so many seconds that nobody interrupts.
        pub(super) fn of(seconds: f64) -> Limit<'static> {
            Limit {
                clock: Instant::now(),
                seconds,
                budget: Budget::new(seconds.min(1e6)),
                stop: &NEVER,
            }
        }
    }

    #[test]
    fn where_everything_is_measured_no_limit_is_reached() {
        let unlimited = STUDIES[0].limit(true, Budget::unlimited(), &NEVER);
        assert_eq!(unlimited.seconds(), f64::INFINITY);
        assert_eq!(unlimited.reached_after(0.85 * unlimited.seconds()), None);
        assert_eq!(unlimited.budget_reached(), None);
        let over = STUDIES[0].limit(true, Budget::new(0.0), &NEVER);
        assert!(over.budget_reached().is_some());
    }

    #[test]
    fn titles_and_csv_files_of_studies_are_unique() {
        for (index, kind) in STUDIES.iter().enumerate() {
            for other in &STUDIES[..index] {
                assert_ne!(kind.csv, other.csv);
                assert_ne!(kind.title, other.title);
            }
            assert!(kind.csv.ends_with(".csv") && kind.csv != "results.csv");
            let columns = (kind.columns)();
            assert!(columns.len() > 1, "{}", kind.csv);
            let blank = kind.blank();
            assert_eq!((blank.csv, blank.title), (kind.csv, kind.title));
            assert!(blank.parts.is_empty() && blank.records.rows().is_empty());
        }
    }

    #[test]
    fn studies_are_asked_for_by_the_names_of_their_files() {
        let names = |names: &[&str]| {
            names
                .iter()
                .map(|&name| name.to_owned())
                .collect::<Vec<_>>()
        };
        let stand = Stand::of(Embedded::City);
        for (asked, expected) in [
            (names(&["none"]), vec![]),
            (
                names(&["hair", "airlight"]),
                vec!["airlight.csv", "hair.csv"],
            ),
        ] {
            let asked = Asked::new(&asked).unwrap();
            let no_time = Budget::new(0.0);
            let studies = run_all(&asked, &stand.subject(), no_time, &NEVER).unwrap();
            let is_asked = |study: &&Study| {
                let mut reasons = study.left_out.iter();
                !reasons.any(|part| part.why.contains("--studies"))
            };
            let found: Vec<_> = studies
                .iter()
                .filter(is_asked)
                .map(|study| study.csv)
                .collect();
            assert_eq!(found, expected);
            assert_eq!(studies.len(), STUDIES.len());
        }
        assert_eq!(Asked::new(&[]).unwrap(), Asked::All);
        for (wrong, part) in [
            (names(&["voxles"]), "did you mean \"voxels\"?"),
            (names(&["none", "hair"]), "by itself"),
            (names(&["hair.csv"]), "no study is called"),
        ] {
            let message = Asked::new(&wrong).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn an_interrupted_comparison_begins_no_study() {
        let stand = Stand::of(Embedded::City);
        let studies = run_all(&Asked::All, &stand.subject(), Budget::new(60.0), &ALREADY).unwrap();
        assert_eq!(studies.len(), STUDIES.len());
        for study in &studies {
            assert!(study.parts.is_empty(), "{}", study.title);
            assert!(study.records.rows().is_empty(), "{}", study.title);
            assert!(!study.left_out.is_empty(), "{}", study.title);
        }
    }

    #[test]
    fn a_study_that_is_pointless_says_why() {
        let stand = Stand::of(Embedded::City);
        let mut subject = stand.subject();
        let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap()];
        subject.emitters = &sun;
        let reasons: Vec<_> = STUDIES
            .iter()
            .map(|kind| (kind.pointless)(&subject))
            .collect();
        assert!(reasons[0].unwrap().contains("closed form"), "{reasons:?}");
        assert!(reasons[3].unwrap().contains("translucent"), "{reasons:?}");
        subject.emitters = &[];
        assert!((precomputed_shadows::KIND.pointless)(&subject).is_some());
        assert!((voxel_grids::KIND.pointless)(&subject).is_some());
    }
}
