//! How errors fall with steps, and with time: the paper's figures 5 and 6.

use lighting::methods::Registry;
use lighting::methods::reduced::Reduction;

use super::test_scene::TestScene;
use super::{BRUTE, HYBRID, Limit, Measured, TEXTURED, TEXTURED_BRUTE, Variant, record};
use crate::compare::study::{Axis, Chart, Charts, Part, Point, Scale, Series, Shape, Study, Unit};
use crate::failure::Failure;
use crate::format::{seconds, significant};

const STEPS: &[u32] = &[10, 25, 50, 75, 100, 150, 300, 500];
const QUICK_STEPS: &[u32] = &[10, 75];

/// The measurements of a variant.
struct Curve {
    variant: Variant,
    measured: Vec<(u32, Measured)>,
}

/// Both figures, as far as the time allows.
pub(super) fn measure(
    registry: &Registry,
    scene: &TestScene,
    quick: bool,
    (study, limit): (&mut Study, &Limit<'_>),
) -> Result<(), Failure> {
    let steps = if quick { QUICK_STEPS } else { STEPS };
    for (title, variants) in [
        ("A lamp", [BRUTE, HYBRID]),
        ("A spotlight with a cookie", [TEXTURED_BRUTE, TEXTURED]),
    ] {
        let mut curves = variants.map(|variant| Curve {
            variant,
            measured: Vec::new(),
        });
        for &steps in steps {
            if let Some(why) = limit.reached() {
                study.leave_out(&format!("{title}: more steps"), why);
                break;
            }
            for curve in &mut curves {
                let measured = scene.frame(registry, curve.variant, steps, Reduction::NONE)?;
                curve.measured.push((steps, measured));
                record(
                    study,
                    "rmse of steps",
                    curve.variant.name,
                    steps,
                    measured.rmse,
                );
                let seconds = measured.seconds[1];
                record(
                    study,
                    "seconds of steps",
                    curve.variant.name,
                    steps,
                    seconds,
                );
            }
        }
        if !curves[0].measured.is_empty() {
            study.parts.push(Part::Charts(Charts {
                share_legend: true,
                all: vec![
                    chart(
                        &format!("{title}: equal steps"),
                        "steps",
                        Unit::Number,
                        &curves,
                        |steps, _| f64::from(steps),
                    ),
                    chart(
                        &format!("{title}: equal cost"),
                        "time of a frame",
                        Unit::Seconds,
                        &curves,
                        |_, measured| measured.seconds[1],
                    ),
                ],
            }));
        }
    }
    Ok(())
}

fn chart(
    title: &str,
    label: &str,
    unit: Unit,
    curves: &[Curve],
    x: impl Fn(u32, &Measured) -> f64,
) -> Chart {
    let point = |variant: Variant, (steps, measured): &(u32, Measured)| {
        let x = x(*steps, measured);
        Point {
            x,
            y: measured.rmse,
            spread: [x; 2],
            label: steps.to_string(),
            title: format!(
                "{}, {steps} steps: {} % in {}",
                variant.name,
                significant(100.0 * measured.rmse),
                seconds(measured.seconds[1])
            ),
        }
    };
    let series = |curve: &Curve| Series {
        name: curve.variant.name.into(),
        aside: String::new(),
        key: curve.variant.key,
        competes: true,
        shape: Shape::Points,
        points: curve
            .measured
            .iter()
            .map(|m| point(curve.variant, m))
            .collect(),
    };
    Chart {
        title: title.into(),
        caption: "as figures 5 and 6 of the paper".into(),
        description: format!("error against {label}, both logarithmic"),
        x: Axis {
            label: label.into(),
            scale: Scale::Log,
            unit,
        },
        y: Axis {
            label: "RMSE over mean".into(),
            scale: Scale::Log,
            unit: Unit::Share,
        },
        front: false,
        series: curves.iter().map(series).collect(),
    }
}
