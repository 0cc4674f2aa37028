//! The reference as a picture, and each method's difference to it.

use maud::{Markup, html};

use super::plots::short_name;
use super::summary::setting;
use crate::compare::results::{Measurement, Results};
use crate::failure::Failure;
use crate::format::{error, significant};
use crate::picture::{Picture, data_uri};

pub(super) fn section(results: &Results) -> Result<Markup, Failure> {
    let pictures = &results.pictures;
    let composite = pictures.surfaces.plus(&pictures.airlight);
    let exposure = composite.automatic_exposure();
    let mut references = Vec::new();
    for (title, picture) in [
        ("Reference: surfaces and airlight", &composite),
        ("Reference: airlight alone", &pictures.airlight),
    ] {
        references.push((title, image(&picture.png(exposure)?, picture, title)));
    }
    let methods = methods(results, exposure)?;
    Ok(html! {
        h2 { "Pictures" }
        p.soft { "Radiance times 2" sup { (format!("{exposure:.1}")) } ", then 1 − exp(−x) per channel, then sRGB: the same for every picture." }
        .pictures {
            @for (title, image) in references {
                figure { figcaption { (title) } (image) }
            }
        }
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
    let mut pairs = Vec::new();
    for shown in &pictures.methods {
        let m = &results.measurements[shown.measurement];
        let airlight = shown.airlight.png(exposure)?;
        let difference = shown.airlight.difference_png(&pictures.airlight, scale)?;
        pairs.push(html! {
            figure.pair {
                figcaption { (caption(results, m)) }
                (image(&airlight, &shown.airlight, &results.methods[m.method].title))
                (image(&difference, &shown.airlight, "difference"))
            }
        });
    }
    Ok(html! {
        h3 { "Airlight by method, and its difference to the reference" }
        p.soft {
            "Differences of luminance: too dark " span.scale aria-hidden="true" {} " too bright. Full colour is ±"
            (significant(f64::from(scale))) (of_the_mean)
            ", or more; the ramp is a square root, so that small differences show. The scale is the same for all."
        }
        .pairs {
            @for pair in pairs {
                (pair)
            }
        }
    })
}

fn caption(results: &Results, m: &Measurement) -> Markup {
    html! {
        b { (setting(results, m)) }
        @if results.backends.len() > 1 {
            " on " (short_name(&m.backend, m.representative))
        }
        ": RMSE " (error(m.error.rmse, results.reference.absolute))
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
    fn the_scale_of_differences_is_a_round_number() {
        let mut results = example();
        // The picture is 0.01 brighter than the reference.
        assert!((difference_scale(&results) / 0.02 - 1.0).abs() < 0.6);
        results.pictures.methods[0].airlight = results.pictures.airlight.clone();
        assert!(difference_scale(&results) > 0.0);
        let html = section(&results).unwrap().into_string();
        assert_eq!(html.matches("<img").count(), 4);
        assert!(!html.contains("NaN"));
    }
}
