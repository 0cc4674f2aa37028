//! The reference as a picture, and each method's difference to it.

use maud::{Markup, html};

use super::plots::short_name;
use crate::compare::results::{Measurement, Results};
use crate::failure::Failure;
use crate::format::{error, significant};
use crate::parse::Size;
use crate::picture::{Picture, data_uri};

pub(super) fn section(results: &Results) -> Result<Markup, Failure> {
    let pictures = &results.pictures;
    let composite = pictures.surfaces.plus(&pictures.airlight);
    let exposure = composite.automatic_exposure();
    let composite = image(&composite.png(exposure)?, &composite, "surfaces and fog");
    let airlight = pictures.airlight.png(exposure)?;
    let airlight = image(&airlight, &pictures.airlight, "light in the fog");
    let methods = methods(results, exposure)?;
    Ok(html! {
        h2 { "Pictures" }
        .pictures {
            figure {
                figcaption { b { "The scene" } ": surfaces, and the light in the fog." }
                (composite)
            }
            figure #reference {
                figcaption { b { "Reference" } ": the light in the fog alone, which is what methods compute." }
                (airlight)
            }
        }
        p.soft { "All pictures have the same exposure: radiance times 2" sup { (format!("{exposure:.1}")) } ", then 1 − exp(−x) per channel, then sRGB. Files beside this page hold them as linear radiance: " code { "surfaces.exr" } " and " code { "airlight-*.exr" } "." }
        (methods)
    })
}

/// The airlight of each method beside its difference.
fn methods(results: &Results, exposure: f32) -> Result<Markup, Failure> {
    let pictures = &results.pictures;
    if pictures.methods.is_empty() {
        return Ok(Markup::default());
    }
    let scale = difference_scale(results);
    let of_the_mean = if results.reference.absolute || results.reference.mean <= 0.0 {
        String::new()
    } else {
        let share = f64::from(scale) / results.reference.mean;
        format!(", {} of the mean radiance", error(share, false))
    };
    let (mut pairs, mut on_software) = (Vec::new(), Vec::new());
    for shown in &pictures.methods {
        let m = &results.measurements[shown.measurement];
        let airlight = shown.airlight.png(exposure)?;
        let difference = shown.airlight.difference_png(&pictures.airlight, scale)?;
        let name = name(results, m);
        let is_first = results.methods[m.method].is_baseline && m.representative;
        let group = if m.representative {
            &mut pairs
        } else {
            &mut on_software
        };
        group.push(html! {
            figure.pair data-name=(name) data-first[is_first] {
                figcaption {
                    b { (name) }
                    ": RMSE " (error(m.error.rmse, results.reference.absolute))
                }
                (image(&airlight, &shown.airlight, &name))
                (image(&difference, &shown.airlight, &format!("difference of {name}")))
            }
        });
    }
    Ok(html! {
        h3 { "Each method, and its signed difference to the reference" }
        (viewer(pictures.airlight.size))
        p.soft.above {
            "Differences of luminance: too dark " span.scale role="img" aria-label="from blue over grey to orange" {} " too bright. Full colour is ±"
            (significant(f64::from(scale))) (of_the_mean)
            ", or more; the ramp is a square root, so that small differences show. The scale is the same for all."
        }
        .pairs {
            @for pair in pairs {
                (pair)
            }
        }
        @if !on_software.is_empty() {
            details {
                summary { "Pictures of the software GPU" }
                .pairs {
                    @for pair in on_software {
                        (pair)
                    }
                }
            }
        }
    })
}

/// The slider between the reference and a method, which a script fills; without one
/// it stays hidden, and the pictures below are all there is.
fn viewer(size: Size) -> Markup {
    html! {
        #viewer hidden {
            .controls {
                label { "Compare the reference with " select data-part="method" {} }
                label { input type="checkbox" data-part="difference"; " its difference" }
                span role="group" aria-label="zoom" {
                    @for zoom in [1, 2, 4, 8] {
                        button type="button" data-zoom=(zoom) aria-pressed=(zoom == 1) { (zoom) "×" }
                    }
                }
            }
            .stage data-part="stage" tabindex="0" style={ "aspect-ratio:" (size.width) "/" (size.height) } {
                .canvas data-part="canvas" {
                    img data-part="before" alt="reference";
                    img data-part="after" alt="";
                    .divider data-part="divider" {}
                }
            }
            input type="range" min="0" max="1000" value="500" data-part="slider" aria-label="where the reference ends";
            .sides { span { "← reference" } span data-part="name" {} }
        }
    }
}

/// A setting, with its backend if several compete or its times mean nothing.
fn name(results: &Results, m: &Measurement) -> String {
    let setting = results.setting(m);
    if results.several_compete() || !m.representative {
        format!("{setting}, {}", short_name(&m.backend, m.representative))
    } else {
        setting
    }
}

/// The geometric mean, over the pictures of methods that sample a shadow map,
/// of the 99th percentile of their differences, rounded up to 1, 2 or 5 times
/// a power of ten. Good and bad methods can both be told apart at it.
fn difference_scale(results: &Results) -> f32 {
    let pictures = &results.pictures;
    let sampled = |m: &Measurement| results.methods[m.method].samples_shadow_map;
    let mut logs = Vec::new();
    for sampling_only in [true, false] {
        for shown in &pictures.methods {
            if sampling_only && !sampled(&results.measurements[shown.measurement]) {
                continue;
            }
            let sorted = shown.airlight.sorted_differences(&pictures.airlight);
            let value = sorted[(sorted.len() - 1) * 99 / 100];
            if value > 0.0 && value.is_finite() {
                logs.push(value.log10());
            }
        }
        if !logs.is_empty() {
            break;
        }
    }
    if logs.is_empty() {
        return 1e-6_f32.max(results.reference.mean as f32 * 1e-6);
    }
    let mean = logs.iter().sum::<f32>() / logs.len() as f32;
    let power = 10_f32.powf(mean.floor());
    let step = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|step| *step * power >= 10_f32.powf(mean))
        .unwrap_or(10.0);
    step * power
}

fn image(png: &[u8], picture: &Picture, description: &str) -> Markup {
    html! {
        img src=(data_uri(png)) width=(picture.size.width) height=(picture.size.height) alt=(description);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::example;

    #[test]
    fn without_a_script_every_picture_is_there_and_the_slider_is_hidden() {
        let html = section(&example()).unwrap().into_string();
        assert!(html.contains("id=\"viewer\" hidden>"), "{html}");
        assert_eq!(html.matches("<figure").count(), 3);
        assert_eq!(html.matches("<figcaption").count(), 3);
        let script = include_str!("viewer.js");
        for part in html.split("data-part=\"").skip(1) {
            let name = part.split('"').next().unwrap();
            assert!(script.contains(&format!("\"{name}\"")), "{name}");
        }
    }

    #[test]
    fn the_scale_of_differences_is_a_round_number() {
        let mut results = example();
        // The picture is 0.01 brighter than the reference.
        assert!((difference_scale(&results) / 0.02 - 1.0).abs() < 0.6);
        results.pictures.methods[0].airlight = results.pictures.airlight.clone();
        assert!(difference_scale(&results) > 0.0);
        let html = section(&results).unwrap().into_string();
        assert_eq!(html.matches("src=\"data:image/png").count(), 4);
        assert!(!html.contains("NaN"));
    }
}
