//! How everything was measured, in words.

use maud::{Markup, html};

use crate::compare::results::Results;
use crate::format::{count, error, seconds, significant};

pub(super) fn section(results: &Results) -> Markup {
    let reference = &results.reference;
    let unit = if reference.absolute {
        "The reference's mean radiance is 0, so errors are absolute, in units of radiance."
    } else {
        "Errors are divided by the reference's mean radiance, so 1 % is a hundredth of the mean brightness of the airlight."
    };
    let gpu = results.backends.iter().any(|backend| backend != "cpu");
    html! {
        h2 { "How this was measured" }
        ul {
            li {
                b { "What is compared" }
                ": the airlight, which is the light that fog "
                @if reference.sees_media { "and smoke scatter" } @else { "scatters" }
                " towards the eye along each ray of the picture, summed over the lights. Surfaces are the same for all methods and do not count in any error or time."
            }
            li {
                b { "Reference" }
                ": " (way(results)) ". Took " (seconds(reference.seconds)) ". Mean radiance " (significant(reference.mean)) "."
            }
            li {
                b { "Errors" }
                ": linear radiance over all pixels and colour channels. " (unit)
                " RMSE is the root of the mean square error, and max the largest difference. p99 is the 99th percentile of the error relative to the pixel's own radiance, and relMSE the mean square of this relative error. FLIP (HDR-FLIP) is the difference that a viewer perceives, from 0 to 1."
            }
            li {
                b { "Times" }
                ": a frame computes the airlight of one picture along given rays. Its time is the median of " (repetitions(results))
                ", which alternate between methods; bars span the fastest and the slowest. Two methods are called equally fast where these spans overlap. Build is the time for what has to exist first: the BVH, or the shadow maps ("
                (results.shadow_maps) "). "
                @if gpu {
                    "On a GPU a frame is recorded, submitted and waited for; pipelines are built, and rays and shadow maps uploaded, before the first one, and the picture is read back after the clock has stopped. "
                }
                @if let Some(backend) = results.software() {
                    b { "Times of " (backend) " are not representative" }
                    ": the CPU emulates the GPU. They are folded away and are not used elsewhere on this page. "
                }
                "Times grow with the picture and the map: compare ratios, and only within one report."
            }
            li {
                b { "Shadow maps" }
                " limit the methods that sample them: a march converges to what its map shows, not to the reference. The dashed line is the error of the exact lit runs of the map; methods that filter or interpolate may be below it. Where a curve turns flat, more steps are wasted and a finer map is needed ("
                code { "--map" }
                "). A frame of voxelized shadow volumes makes the voxels anew for each light. A quadrature with a fixed number of nodes has a floor of its own where the light along a lit run has kinks: the edge of a spotlight, the faces of a bounded medium."
            }
            li { b { "Total" } ": " (seconds(results.seconds_total)) "." }
        }
    }
}

/// How the reference was found.
fn way(results: &Results) -> String {
    let reference = &results.reference;
    let bound = error(reference.bound, reference.absolute);
    match reference.parts {
        None if reference.sees_media => format!(
            "exact lit runs of every ray, cut at the faces of cells and the edges of media; on each part the light that is scattered at Gauss's nodes, \
dimmed by the exact optical depth of all media towards eye and light, in double precision, by code that shares only its input with the methods: rays, lights, triangles, media. \
Parts are halved until n and 2n nodes differ by less than {} per pixel; the largest difference of a pixel, which is far above its error, is {bound}",
            error(reference.tolerance, false)
        ),
        None if reference.has_areas => format!(
            "exact lit runs of every ray × quadrature in double precision, integrated over the area lights, which are divided until the parts agree with their quarters, \
by code that shares only its input with the methods: rays with their ends, lights, triangles. Asked for {} per pixel; the largest estimate of the error of a pixel is {bound}. \
Methods that take an area light for a few points (--lights) are no nearer to it than these points",
            error(reference.tolerance, false)
        ),
        None => format!(
            "the exact lit runs of every ray, each integrated in double precision with a bound on the error, \
by code that shares only its input with the methods: rays, lights, triangles. Asked for {} per pixel; the largest bound of a pixel is {bound}",
            error(reference.tolerance, false)
        ),
        Some(parts) => format!(
            "exact lit runs of every ray, cut into {parts} parts, each times the exact transmittance of hair and smoke at two points of it, in double precision, \
by code that shares only its input with the methods. The largest difference that it makes for a pixel to take one point of each part is {bound}, next to the edges of hair"
        ),
    }
}

/// How often a frame was measured.
fn repetitions(results: &Results) -> String {
    let all = results.measurements.iter().map(|m| m.frame.repetitions);
    match (all.clone().min(), all.max()) {
        (Some(a), Some(b)) if a == b => count(a, "run"),
        (Some(a), Some(b)) => format!("{a} to {b} runs"),
        _ => "no runs".into(),
    }
}
