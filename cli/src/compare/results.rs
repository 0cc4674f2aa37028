//! What a comparison found: plain data between measuring and reporting.

use super::alone::Alone;
use super::curves::Curves;
use super::dag::Dag;
use super::voxels::Voxels;
use crate::methods::Method;
use crate::parse::Size;
use crate::picture::Picture;

/// Everything a report says.
#[derive(Debug)]
pub(crate) struct Results {
    /// The scene's name.
    pub(crate) scene: String,
    /// Kinds and numbers of lights, short.
    pub(crate) light: String,
    /// The same as a noun.
    pub(crate) lights: String,
    /// The medium in words.
    pub(crate) medium: String,
    /// Its phase function in words.
    pub(crate) phase: String,
    /// Number of triangles.
    pub(crate) triangles: usize,
    /// Size of the picture that was measured.
    pub(crate) size: Size,
    /// Shadow maps in words.
    pub(crate) shadow_maps: String,
    /// What was placed, assumed or reduced.
    pub(crate) notes: Vec<String>,
    /// What ran.
    pub(crate) ran: Vec<String>,
    /// What did not, and why.
    pub(crate) left_out: Vec<LeftOut>,
    /// Processor and threads.
    pub(crate) machine: String,
    /// Labels of the backends that were measured.
    pub(crate) backends: Vec<String>,
    pub(crate) reference: ReferenceFacts,
    pub(crate) measurements: Vec<Measurement>,
    /// Evaluators of airlight by themselves.
    pub(crate) alone: Vec<Alone>,
    /// Curves of transmittance by themselves.
    pub(crate) curves: Curves,
    /// Voxelized shadow volumes by themselves.
    pub(crate) voxels: Voxels,
    /// Baked shadows by themselves.
    pub(crate) dag: Dag,
    /// None if there is no airlight.
    pub(crate) pictures: Pictures,
    /// Wall time of everything.
    pub(crate) seconds_total: f64,
}

impl Results {
    /// What may win: measurements whose times mean something.
    pub(crate) fn representative(&self) -> impl Iterator<Item = &Measurement> + Clone {
        self.measurements.iter().filter(|m| m.representative)
    }

    /// The backend whose times mean nothing, if there is one.
    pub(crate) fn software(&self) -> Option<&str> {
        let mut all = self.measurements.iter();
        all.find(|m| !m.representative).map(|m| m.backend.as_str())
    }
}

/// Something that the scene or the budget made pointless.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LeftOut {
    pub(crate) what: String,
    pub(crate) why: String,
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
    /// Parts that rays were cut into behind translucent casters, if there are
    /// any.
    pub(crate) parts: Option<u32>,
}

/// One method at one quality on one backend.
#[derive(Debug, Clone)]
pub(crate) struct Measurement {
    pub(crate) method: &'static Method,
    /// Label of the backend.
    pub(crate) backend: String,
    /// False on a software adapter: the time says nothing about a GPU.
    pub(crate) representative: bool,
    pub(crate) quality: u32,
    pub(crate) error: Errors,
    /// Building what the frame needs: a BVH, shadow maps.
    pub(crate) seconds_build: f64,
    /// The airlight of one picture.
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
}

/// Repeated measurements of one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Times {
    pub(crate) median: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) repetitions: usize,
}

impl Times {
    /// From any number of durations above 0 in any order.
    pub(crate) fn of(seconds: &[f64]) -> Self {
        let mut sorted = seconds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        assert!(n > 0, "a time is measured at least once");
        Self {
            median: 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
            low: sorted[0],
            high: sorted[n - 1],
            repetitions: n,
        }
    }
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
    method: Option<&Method>,
    target: f64,
) -> Option<&'a Measurement> {
    measurements
        .into_iter()
        .filter(|m| method.is_none_or(|method| std::ptr::eq(m.method, method)))
        .filter(|m| m.error.rmse <= target)
        .min_by(|a, b| a.frame.median.total_cmp(&b.frame.median))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compare::alone::{Family, Judgement};
    use crate::compare::{curves, dag, voxels};
    use crate::methods::METHODS;

    /// Two evaluators, one of which fails on stiff segments.
    fn example_alone() -> Vec<Alone> {
        let judgement = |worst: f64| Judgement {
            worst,
            median: 1e-6,
            time: Times::of(&[1e-8, 2e-8]),
        };
        [
            (Family::Table, "64 KiB", 1e-4),
            (Family::Published, "512²", 10.0),
        ]
        .map(|(family, setting, worst)| Alone {
            family,
            setting: setting.into(),
            bytes: 1 << 16,
            seconds_build: 0.2,
            easy: judgement(1e-5),
            stiff: judgement(worst),
        })
        .to_vec()
    }

    /// One kind of curve on one subject, and a figure of one line.
    fn example_curves() -> Curves {
        let row = curves::Row {
            family: curves::Family::Area,
            setting: "8".into(),
            mean: [0.01; 3],
            max: [0.1; 3],
            insertion: Times::of(&[1e-7]),
            lookup: Times::of(&[2e-8]),
            bytes: 64.0,
        };
        Curves {
            subjects: vec![curves::Subject {
                name: "smoke & \"hair\"".into(),
                rays: 9,
                segments: 50.0,
                rows: vec![row],
            }],
            figures: vec![curves::Figure {
                title: "a ray <of> light".into(),
                depths: vec![0.0, 1.0],
                lines: vec![curves::Line {
                    name: "exact".into(),
                    slot: 0,
                    values: vec![1.0, 0.5],
                }],
            }],
        }
    }

    /// One resolution, and a frame of one backend.
    fn example_voxels() -> Voxels {
        let times = Times::of(&[1e-3]);
        Voxels {
            steps: vec![voxels::Steps {
                backend: "cpu".into(),
                rectify: times,
                voxelise: times,
                extrude: times,
                average: times,
                runs: times,
                rays: 8,
            }],
            refinements: voxels::Axis::ALL
                .map(|axis| voxels::Refinement {
                    axis,
                    size: 64,
                    rest_coarse: 0.1,
                    rest_fine: 0.01,
                })
                .to_vec(),
            detachments: vec![voxels::Detachment {
                alpha: 64,
                paper: [0.2, 0.3],
                unbiased: [0.01, 0.1],
            }],
            biased: 0.02,
            unbiased: 0.01,
            left_out: Vec::new(),
        }
    }

    /// One of everything about baked shadows.
    fn example_dag() -> Dag {
        Dag {
            light: "the <sun>".into(),
            sizes: Some(dag::Sizes {
                resolution: 512,
                edges: 0,
                rows: vec![dag::SizeRow {
                    rule: "2015",
                    bytes: [3000, 1000],
                    seconds: [0.1, 0.4],
                }],
            }),
            bakes: [2048, 4096]
                .map(|resolution| dag::Bake {
                    resolution,
                    stages: [
                        (0.1, None),
                        (0.2, Some(1 << 30)),
                        (0.01, None),
                        (0.02, None),
                    ],
                    bytes: 4000,
                })
                .to_vec(),
            filters: Some(dag::Filters {
                size: Size {
                    width: 4,
                    height: 2,
                },
                resolution: 512,
                receivers: 0,
                rows: vec![(9, [Times::of(&[1e-3]), Times::of(&[2e-3])])],
            }),
            ..Dag::default()
        }
    }

    /// Results with a made-up error of 1/quality and a time of quality ms.
    pub(crate) fn example() -> Results {
        let size = Size {
            width: 4,
            height: 2,
        };
        let flat = |value: f32| Picture::new(size, &[[value; 4]; 8]);
        let mut measurements = Vec::new();
        for (slot, method) in METHODS.iter().enumerate() {
            for &quality in method.qualities {
                let error = 0.5 / f64::from(quality).powi(1 + (slot % 2) as i32);
                measurements.push(Measurement {
                    method,
                    backend: "cpu".into(),
                    representative: true,
                    quality,
                    error: Errors {
                        rmse: error,
                        max: 10.0 * error,
                        rel_p99: 2.0 * error,
                    },
                    seconds_build: 0.004,
                    frame: Times::of(&[1e-3 * f64::from(quality), 1.2e-3 * f64::from(quality)]),
                    bytes: 24 << 20,
                });
            }
        }
        Results {
            scene: "a <test>, \"quoted\"".into(),
            light: "point".into(),
            lights: "point light".into(),
            medium: "sigma_s 0.1".into(),
            phase: "isotropic".into(),
            triangles: 12,
            size,
            shadow_maps: "one cube map".into(),
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
            },
            pictures: Pictures {
                surfaces: flat(0.2),
                airlight: flat(0.3),
                methods: vec![MethodPicture {
                    measurement: 1,
                    airlight: flat(0.31),
                }],
            },
            measurements,
            alone: example_alone(),
            curves: example_curves(),
            voxels: example_voxels(),
            dag: example_dag(),
            seconds_total: 20.0,
        }
    }

    /// The same with a GPU in software that is faster and better than all.
    pub(crate) fn example_with_software() -> Results {
        let mut results = example();
        let label = "gpu (a, \"b\", software)";
        let mut more = results.measurements.clone();
        more.retain(|m| !m.method.visibility.is_traced());
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
    fn the_median_is_in_the_middle() {
        let times = Times::of(&[3.0, 1.0, 2.0, 10.0]);
        assert_eq!((times.median, times.low, times.high), (2.5, 1.0, 10.0));
        assert_eq!(Times::of(&[7.0]).median, 7.0);
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
        let march = METHODS.iter().find(|m| m.title == "ray marching").unwrap();
        assert_eq!(fastest_within(all, Some(march), 0.04).unwrap().quality, 16);
        assert!(fastest_within(all, Some(march), 1e-9).is_none());
        assert!(fastest_within(all, None, 0.04).unwrap().quality <= 16);
    }
}
