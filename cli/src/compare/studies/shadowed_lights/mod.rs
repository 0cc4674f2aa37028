//! All lights of the scene with precomputed shadows: the time and memory of each bake, their
//! errors beside those of the shadow maps of engines, and the cost of a frame of them.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of Voxelized
//! Shadows, I3D 2015, section 4: size and time of each light (figure 3), frames of a
//! flight (figure 4), and closed against open scenes (table 4).

mod bakes;
mod baselines;
mod frames;

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::direct_light::ShadowsOfMany;
use lighting::precomputed::BakedShadow;
use lighting::scene::Geometry;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::{Emitter, SurfacePoint};

use super::{Kind, Limit, Subject, record, value_columns};
use crate::compare::study::Study;
use crate::failure::Failure;
use crate::format::count;
use crate::parse::Size;
use crate::progress;

pub(super) const KIND: Kind = Kind {
    title: "lights with precomputed shadows",
    csv: "shadowed-lights.csv",
    in_fog: false,
    columns: value_columns,
    seconds: Some([1.5, 90.0]),
    pointless,
    run,
};

/// Resolutions, pictures and frames.
struct Extent {
    /// The resolution of the grids of each light, and of its plain shadow map.
    voxels: u32,
    /// The resolution of each of the four cascades of a sun.
    cascade: u32,
    /// The size of the picture on whose surfaces errors are measured.
    errors: Size,
    /// The size of frames, and their number.
    picture: Size,
    frames: u32,
    /// The largest number of lights.
    lights: usize,
}

const ALL: Extent = Extent {
    voxels: 2048,
    cascade: 2048,
    errors: Size {
        width: 480,
        height: 270,
    },
    picture: Size {
        width: 1920,
        height: 1080,
    },
    frames: 8,
    lights: usize::MAX,
};
const QUICK: Extent = Extent {
    voxels: 256,
    cascade: 128,
    errors: Size {
        width: 64,
        height: 36,
    },
    picture: Size {
        width: 64,
        height: 36,
    },
    frames: 2,
    lights: 4,
};

/// A light and what was baked for it.
struct BakedLight {
    emitter: Emitter,
    /// Its size as packed nodes.
    shadow: BakedShadow,
    /// The time from sorted triangles to packed nodes.
    seconds: f64,
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    let none = subject.emitters.is_empty();
    none.then_some("no light reaches the view")
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let extent = if subject.quick { &QUICK } else { &ALL };
    if let Some(why) = limit.reached() {
        study.leave_out("", why);
        return Ok(study);
    }
    let bar = progress::bar("lights with precomputed shadows", 3);
    let lights = bakes::measure(&mut study, subject, extent, limit)?;
    bar.inc(1);
    if !lights.is_empty() {
        match limit.reached() {
            None => baselines::measure(&mut study, subject, extent, (&lights, limit))?,
            Some(why) => study.leave_out("shadow maps", why),
        }
        bar.inc(1);
        match limit.reached() {
            None => frames::measure(&mut study, subject, extent, (&lights, limit))?,
            Some(why) => study.leave_out("frames", why),
        }
    }
    bar.finish_and_clear();
    if subject.quick {
        study.leave_out("more lights, voxels and frames", "--quick");
    }
    study.introduction = format!(
        "{} of the scene, each with precomputed voxelized shadows of {}³ voxels in every grid (a \
         light that shines in all directions has six), on the CPU. Exact visibility is that of \
         shadow rays. To compare scenes, and a scene with its open twin, run this on each: sizes and \
         errors are the same on every machine, of times only the ratios.{}",
        count(lights.len(), "light"),
        extent.voxels,
        subject.dynamic_baked()
    );
    Ok(study)
}

/// The surfaces of a view, of one reflectance.
fn points(geometry: &Geometry, view: &View) -> Vec<SurfacePoint> {
    let pixels = view.rays().iter().zip(view.hits());
    let point = pixels.map(|(ray, hit)| {
        let hit = hit.as_ref()?;
        let [a, b, c] = geometry.triangles()[hit.triangle as usize];
        let outside = (b - a).cross(c - a).normalize_or_zero();
        let towards_eye = outside.dot(ray.direction()) < 0.0;
        let normal = if towards_eye { outside } else { -outside };
        SurfacePoint::new(ray.at(hit.distance), normal, Vec3::ONE)
    });
    point.map(Option::unwrap_or_default).collect()
}

/// The direction and the distance of an emitter, as seen from a surface; `None` if none of its
/// light reaches the front of the surface.
fn lit_from(emitter: &Emitter, point: &SurfacePoint) -> Option<(Vec3, f32)> {
    let (direction, distance) = match emitter {
        Emitter::Directional(sun) => (-sun.direction(), f32::INFINITY),
        Emitter::Point(lamp) => {
            let way = lamp.position() - point.position();
            let distance = way.length();
            let direction = way.try_normalize()?;
            let dark = lamp.emission().factor(-direction) == Vec3::ZERO;
            if distance > lamp.range() || dark {
                return None;
            }
            (direction, distance)
        }
    };
    let faces = point.reflects() && direction.dot(point.normal()) > 0.0;
    faces.then_some((direction, distance))
}

/// Exact visibility, by shadow rays.
struct Traced<'a> {
    tracer: &'a Tracer,
    emitters: &'a [Emitter],
}

impl ShadowsOfMany for Traced<'_> {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let Some(point) = SurfacePoint::new(point, normal, Vec3::ONE) else {
            return Vec3::ZERO;
        };
        let Some((direction, distance)) = lit_from(&self.emitters[light], &point) else {
            return Vec3::ZERO;
        };
        // Far above the rounding of the point, far below any detail.
        let position = point.position();
        let start = position + 1e-5 * (1.0 + position.abs().max_element()) * point.normal();
        let blocked = self.tracer.occluded(start, direction, 0.0, distance);
        Vec3::splat(f32::from(u8::from(!blocked)))
    }
}

/// The view of a camera.
fn view(subject: &Subject<'_>, size: Size) -> Result<View, Failure> {
    let Size { width, height } = size;
    let view = View::new(&Cpu::new(), subject.camera, subject.tracer, width, height)?;
    Ok(view)
}

/// A title for people of the name of a record.
fn capitalised(name: &str) -> String {
    let mut title = name.to_owned();
    if let Some(first) = title.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    title
}

#[cfg(test)]
mod tests {
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;
    use crate::compare::study::Value;

    fn value(study: &Study, what: &str, of: &str) -> f64 {
        let rows = study.records.rows().iter();
        let mut of_both =
            rows.filter(|row| row.cells[0].text() == Some(what) && row.cells[1].text() == Some(of));
        let row = of_both.next().unwrap_or_else(|| panic!("{what} of {of}"));
        assert!(of_both.next().is_none(), "{what} of {of} twice");
        match row.cells[3].value {
            Value::Number(value) => value,
            ref other => panic!("{other:?}"),
        }
    }

    #[test]
    fn lamps_and_suns_have_every_part_and_grids_are_as_right_as_maps() {
        for (embedded, kind) in [(Embedded::City, "sun"), (Embedded::Fence, "lamps")] {
            let stand = Stand::of(embedded);
            let study = run(&stand.subject(), &Limit::of(f64::INFINITY)).unwrap();
            assert_eq!(study.left_out.len(), 1, "{:?}", study.left_out);
            for row in study.records.rows() {
                assert!(
                    matches!(row.cells[3].value, Value::Number(value) if value >= 0.0),
                    "{row:?}"
                );
            }
            // Texels of these few are wide; maps have the same, and cascades narrower ones.
            let wrong =
                |way: &str| value(&study, "wrong lookups of 1x1", &format!("{kind}, {way}"));
            let [grids, maps] = ["grids", "16-bit maps"].map(wrong);
            assert!(grids < 1.3 * maps + 0.02, "{kind}: {grids} {maps}");
            assert!(kind == "lamps" || wrong("four cascades") < 0.8 * grids);
            let [closed, open] =
                ["as it is", "as open surfaces"].map(|of| value(&study, "bytes of all lights", of));
            assert!(closed <= 1.05 * open, "{closed} {open}");
        }
    }

    #[test]
    fn nothing_is_begun_when_the_time_is_over() {
        let stand = Stand::of(Embedded::Fence);
        let study = run(&stand.subject(), &Limit::of(0.0)).unwrap();
        assert!(study.records.rows().is_empty() && study.left_out.len() == 1);
    }
}
