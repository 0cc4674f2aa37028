//! What a comparison found: plain data between measuring and reporting.

pub(crate) use super::film::Film;
pub(crate) use super::run_facts::RunFacts;
pub(crate) use super::slopes::{Slope, slopes};
pub(crate) use super::study::LeftOut;
use super::study::Study;
pub(crate) use super::times::Times;
use crate::parse::Size;
use crate::picture::Picture;

/// Everything a report says.
#[derive(Debug)]
pub(crate) struct Results {
    /// The program, its arguments and the date.
    pub(crate) run: RunFacts,
    /// The scene's name.
    pub(crate) scene: String,
    /// Kinds and numbers of lights, short.
    pub(crate) light: String,
    /// The same as a noun.
    pub(crate) lights: String,
    /// The medium in words.
    pub(crate) medium: String,
    /// Number of triangles.
    pub(crate) triangles: usize,
    /// The scene in numbers: what is counted, and the count.
    pub(crate) statistics: Vec<(&'static str, String)>,
    /// Size of the picture that was measured.
    pub(crate) size: Size,
    /// Shadow maps in words.
    pub(crate) shadow_maps: String,
    /// The errors that shadow maps of some resolutions have by themselves, first the
    /// resolution of most rows.
    pub(crate) floors: Vec<MapFloor>,
    /// What was placed, assumed or reduced.
    pub(crate) notes: Vec<String>,
    /// The methods, qualities and studies that ran.
    pub(crate) ran: Vec<String>,
    /// Everything that did not run, and why.
    pub(crate) left_out: Vec<LeftOut>,
    /// Processor and threads.
    pub(crate) machine: String,
    /// Labels of the backends that were measured.
    pub(crate) backends: Vec<String>,
    pub(crate) reference: ReferenceFacts,
    /// All methods there are, measured or not; the place of one is its colour.
    pub(crate) methods: Vec<MethodFacts>,
    pub(crate) measurements: Vec<Measurement>,
    /// The studies, which are measured beside the methods.
    pub(crate) studies: Vec<Study>,
    /// The film, if one was asked for.
    pub(crate) film: Option<Film>,
    /// None if there is no airlight.
    pub(crate) pictures: Pictures,
    /// Wall time of everything.
    pub(crate) seconds_total: f64,
}

impl Results {
    /// The error that the shadow maps of a measurement have by themselves, if it was
    /// measured.
    pub(crate) fn floor(&self, m: &Measurement) -> Option<f64> {
        let map = m.map?;
        let floor = self.floors.iter().find(|floor| floor.map == map);
        floor.map(|floor| floor.rmse)
    }

    /// The measurements that may win: those whose times mean something.
    pub(crate) fn representative(&self) -> impl Iterator<Item = &Measurement> + Clone {
        self.measurements.iter().filter(|m| m.representative)
    }

    /// A measurement's method and quality in words.
    pub(crate) fn setting(&self, m: &Measurement) -> String {
        self.methods[m.method].setting(m.quality)
    }

    /// True if the times of more than one backend mean something.
    pub(crate) fn several_compete(&self) -> bool {
        let mut backends = self.representative().map(|m| &m.backend);
        let first = backends.next();
        backends.any(|backend| Some(backend) != first)
    }

    /// The backend whose times mean nothing, if there is one.
    pub(crate) fn software(&self) -> Option<&str> {
        let mut all = self.measurements.iter();
        all.find(|m| !m.representative).map(|m| m.backend.as_str())
    }
}

/// A method as a report knows it.
#[derive(Debug, Clone)]
pub(crate) struct MethodFacts {
    /// Its name on the command line.
    pub(crate) name: String,
    /// Its name in a report.
    pub(crate) title: String,
    /// The unit of its quality: steps, nodes, voxels per axis…
    pub(crate) quality: String,
    /// The two halves of a pair, for CSV.
    pub(crate) visibility: String,
    pub(crate) airlight: String,
    /// False if it leaves the shadows out, as a measure of what they are worth.
    pub(crate) has_shadows: bool,
    /// Plain ray marching, which others are compared with.
    pub(crate) is_baseline: bool,
    /// Methods of game engines.
    pub(crate) is_of_engines: bool,
    /// It samples a shadow map, whose resolution limits it.
    pub(crate) samples_shadow_map: bool,
    /// Its shadow maps are finer where its quality is higher.
    pub(crate) refines_map: bool,
}

impl MethodFacts {
    /// The method at a quality, in words.
    pub(crate) fn setting(&self, quality: u32) -> String {
        format!("{}, {quality} {}", self.title, self.quality)
    }
}

/// The error of the exact lit runs that shadow maps of a resolution show. Errors of methods
/// that look up single texels level out there; methods that filter or interpolate may be better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MapFloor {
    /// Texels per side.
    pub(crate) map: u32,
    /// As [`Errors::rmse`].
    pub(crate) rmse: f64,
}

/// The truth that errors are against.
#[derive(Debug, Clone)]
pub(crate) struct ReferenceFacts {
    pub(crate) seconds: f64,
    /// Relative tolerance asked for per pixel.
    pub(crate) tolerance: f64,
    /// The largest proven error of a pixel, in units of the mean (or absolute).
    pub(crate) bound: f64,
    /// Mean radiance of the airlight.
    pub(crate) mean: f64,
    /// True if the mean is 0 and errors are plain radiances.
    pub(crate) absolute: bool,
    /// The number of parts into which rays were cut behind translucent casters, if there are
    /// any.
    pub(crate) parts: Option<u32>,
    /// Whether there are area lights, over which the reference integrates.
    pub(crate) has_areas: bool,
    /// Whether smoke and fog that thins out are seen.
    pub(crate) sees_media: bool,
}

/// One method at one quality on one backend.
#[derive(Debug, Clone)]
pub(crate) struct Measurement {
    /// Index into [`Results::methods`].
    pub(crate) method: usize,
    /// Label of the backend.
    pub(crate) backend: String,
    /// False on a software adapter: the time says nothing about a GPU.
    pub(crate) representative: bool,
    pub(crate) quality: u32,
    /// Texels per side of its shadow maps; `None` if it has none.
    pub(crate) map: Option<u32>,
    pub(crate) error: Errors,
    /// Time of building all that the frame needs: a BVH, shadow maps.
    pub(crate) seconds_build: f64,
    /// Time of the airlight of one picture.
    pub(crate) frame: Times,
    /// Memory of what was built.
    pub(crate) bytes: u64,
}

/// Errors of the airlight, divided by the reference's mean radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Errors {
    pub(crate) rmse: f64,
    pub(crate) max: f64,
    /// 99th percentile of the relative error of a pixel.
    pub(crate) rel_p99: f64,
    /// Mean squared error relative to the pixel itself (relMSE).
    pub(crate) rel_mse: f64,
    /// How much of it a viewer sees, from 0 to 1 (HDR-FLIP); `None` if there was no time.
    pub(crate) flip: Option<f64>,
}

/// The pictures of a report.
#[derive(Debug)]
pub(crate) struct Pictures {
    /// Surfaces seen through the medium, without airlight.
    pub(crate) surfaces: Picture,
    /// The reference's airlight.
    pub(crate) airlight: Picture,
    /// Airlight by some of the measurements.
    pub(crate) methods: Vec<MethodPicture>,
}

/// The airlight of one measurement as a picture.
#[derive(Debug)]
pub(crate) struct MethodPicture {
    /// Index into [`Results::measurements`].
    pub(crate) measurement: usize,
    pub(crate) airlight: Picture,
}

/// Which of the points (time, error) no other point beats: true if none is at
/// least as good in both and better in one. `None` does not take part.
pub(crate) fn pareto(points: &[Option<(f64, f64)>]) -> Vec<bool> {
    let beaten = |(time, error): (f64, f64)| {
        points
            .iter()
            .flatten()
            .any(|&(t, e)| t <= time && e <= error && (t < time || e < error))
    };
    points
        .iter()
        .map(|point| point.is_some_and(|point| !beaten(point)))
        .collect()
}

/// The fastest measurement of `method` (of any, if `None`) whose error is at
/// most `target`, by its frame time.
pub(crate) fn fastest_within<'a>(
    measurements: impl IntoIterator<Item = &'a Measurement>,
    method: Option<usize>,
    target: f64,
) -> Option<&'a Measurement> {
    measurements
        .into_iter()
        .filter(|m| method.is_none_or(|method| m.method == method))
        .filter(|m| m.error.rmse <= target)
        .min_by(|a, b| a.frame.median.total_cmp(&b.frame.median))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compare::study;

    const STEPS: &[u32] = &[4, 8, 16, 32, 64, 128, 256];

    /// A few methods with their qualities.
    fn example_methods() -> Vec<(MethodFacts, &'static [u32])> {
        let method = |name: &str, title: &str, quality: &str| {
            let (visibility, airlight) = name.split_once(" x ").unwrap();
            MethodFacts {
                name: name.into(),
                title: title.into(),
                quality: quality.into(),
                visibility: visibility.into(),
                airlight: airlight.into(),
                has_shadows: visibility != "none",
                is_baseline: visibility == "march",
                is_of_engines: false,
                samples_shadow_map: !["none", "exact"].contains(&visibility),
                refines_map: false,
            }
        };
        vec![
            (
                method("none x gauss", "no shadows", "Gauss nodes per lit run"),
                &[8],
            ),
            (
                method(
                    "exact x gauss",
                    "exact visibility",
                    "Gauss nodes per lit run",
                ),
                &[2, 4, 8, 16],
            ),
            (method("march x midpoint", "ray marching", "steps"), STEPS),
            (
                method("equi-angular x gauss-1", "equi-angular steps", "steps"),
                STEPS,
            ),
            (
                method("runs x gauss-8", "runs of <voxels>", "voxels per axis"),
                &[64, 128, 256],
            ),
        ]
    }

    /// Results with a made-up error of 1/quality and a time of quality ms.
    pub(crate) fn example() -> Results {
        let size = Size {
            width: 4,
            height: 2,
        };
        let flat = |value: f32| Picture::new(size, &[[value; 4]; 8]);
        let methods: Vec<_> = example_methods().into_iter().map(|m| m.0).collect();
        let mut measurements = Vec::new();
        for (slot, (_, qualities)) in example_methods().iter().enumerate() {
            for &quality in *qualities {
                let error = 0.5 / f64::from(quality).powi(1 + (slot % 2) as i32);
                measurements.push(Measurement {
                    method: slot,
                    backend: "cpu".into(),
                    representative: true,
                    quality,
                    map: methods[slot].samples_shadow_map.then_some(1024),
                    error: Errors {
                        rmse: error,
                        max: 10.0 * error,
                        rel_p99: 2.0 * error,
                        rel_mse: 3.0 * error * error,
                        flip: Some(0.5 * error),
                    },
                    seconds_build: 0.004,
                    frame: Times::of(&[1e-3 * f64::from(quality), 1.2e-3 * f64::from(quality)]),
                    bytes: 24 << 20,
                });
            }
        }
        Results {
            run: RunFacts {
                version: "1.2.3",
                command: "crepuscular compare '<scene>'".into(),
                date: "2026-03-14 15:09 UTC".into(),
            },
            scene: "a <test>, \"quoted\"".into(),
            light: "point".into(),
            lights: "point light".into(),
            medium: "sigma_s 0.1".into(),
            triangles: 12,
            statistics: vec![("triangles", "12".into())],
            size,
            shadow_maps: "one cube map".into(),
            floors: vec![MapFloor {
                map: 1024,
                rmse: 1e-3,
            }],
            notes: vec!["the scene has no camera: placed one".into()],
            ran: vec!["airlight of light 0 (point)".into()],
            left_out: vec![LeftOut {
                what: "light 3".into(),
                why: "it never meets the view".into(),
            }],
            machine: "a processor, 2 threads".into(),
            backends: vec!["cpu".into()],
            reference: ReferenceFacts {
                seconds: 1.5,
                tolerance: 1e-6,
                bound: 3e-7,
                mean: 0.2,
                absolute: false,
                parts: None,
                has_areas: false,
                sees_media: false,
            },
            pictures: Pictures {
                surfaces: flat(0.2),
                airlight: flat(0.3),
                methods: vec![MethodPicture {
                    measurement: 1,
                    airlight: flat(0.31),
                }],
            },
            methods,
            measurements,
            studies: vec![study::tests::example()],
            film: None,
            seconds_total: 20.0,
        }
    }

    /// The same with a GPU in software that is faster and better than all.
    pub(crate) fn example_with_software() -> Results {
        let mut results = example();
        let label = "gpu (a, \"b\", software)";
        let mut more = results.measurements.clone();
        more.retain(|m| results.methods[m.method].visibility != "exact");
        for m in &mut more {
            m.backend = label.into();
            m.representative = false;
            m.frame = Times::of(&[1e-3 * m.frame.median]);
            m.error.rmse *= 0.5;
        }
        results.measurements.extend(more);
        results.backends.push(label.into());
        results
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(1.0, 9.0), (2.0, 5.0), (2.0, 6.0), (3.0, 5.0), (4.0, 1.0)];
        let mut points = points.map(Some).to_vec();
        assert_eq!(pareto(&points), [true, true, false, false, true]);
        points[4] = None;
        assert_eq!(pareto(&points), [true, true, false, false, false]);
        assert_eq!(pareto(&[Some((1.0, 1.0)); 2]), [true, true], "equals");
    }

    #[test]
    fn the_fastest_within_an_error_is_found_per_method() {
        let results = example();
        let all = &results.measurements;
        let mut titles = results.methods.iter().map(|method| &method.title);
        let march = titles.position(|title| title == "ray marching").unwrap();
        assert_eq!(fastest_within(all, Some(march), 0.04).unwrap().quality, 16);
        assert!(fastest_within(all, Some(march), 1e-9).is_none());
        assert!(fastest_within(all, None, 0.04).unwrap().quality <= 16);
    }
}
