//! What a plan leaves out of a tiny frame.

use std::sync::LazyLock;

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::methods::Entry;
use lighting::plan::Plan;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    Bounds, Camera, Cone, Emission, Emitter, Falloff, Geometry, HeightFog, Medium, Mesh,
    PhaseFunction, Ray, Scene,
};
use lighting::visibility::{Exact, VisibilitySource};
use lighting::{LightPath, LitInterval};

use super::Bytes;
use super::frame::{METHODS, Tiny, least};

/// Half the size of the room, m.
const SIZE: f32 = 8.0;

/// The method whose pictures are the truth, its quality, and the same without shadows.
static EXACT: LazyLock<(Entry, u32, (Entry, u32))> = LazyLock::new(|| {
    let exact = METHODS.pair("exact", "quadrature", None);
    let exact = exact.expect("a standard method");
    let quality = exact.about().usual;
    let closed = METHODS.unshadowed(&exact, quality);
    (exact, quality, closed.expect("a closed form"))
});

fn geometry(bytes: &mut Bytes<'_>) -> Option<Geometry> {
    let mut positions = Vec::new();
    for _ in 0..1 + bytes.below(6) {
        let corner = bytes.vector(SIZE);
        let edge = bytes.magnitude(-8.0, 4.0);
        positions.extend([
            corner,
            corner + edge * bytes.direction(),
            corner + edge * bytes.direction(),
        ]);
    }
    let mesh = Mesh {
        triangles: (0..positions.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        positions,
        ..Mesh::default()
    };
    // Triangles without area may be all there are.
    Geometry::new(&Scene::from(mesh)).ok()
}

fn emitter(bytes: &mut Bytes<'_>, eye: Vec3) -> Emitter {
    let intensity = match bytes.below(16) {
        0 => Vec3::ZERO,
        1 => Vec3::X,
        _ => Vec3::splat(bytes.magnitude(-4.0, 10.0)),
    };
    let position = match bytes.below(8) {
        0 => eye,
        1 => eye + bytes.magnitude(-20.0, 0.0) * bytes.direction(),
        _ => bytes.vector(SIZE),
    };
    let axis = bytes.direction();
    let emission = match bytes.below(4) {
        0 => return Emitter::directional(axis, intensity).expect("a unit direction"),
        1 => Emission::Isotropic,
        2 => Emission::Cosine { normal: axis },
        _ => {
            let outer = bytes.magnitude(-9.0, 0.6);
            let cone = Cone {
                inner: bytes.unit() * 0.99 * outer,
                outer,
            };
            let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, axis);
            Emission::spot(rotation, cone, None).expect("a cone below 90 degrees")
        }
    };
    let range = match bytes.below(3) {
        0 => f32::INFINITY,
        _ => bytes.magnitude(-6.0, 5.0),
    };
    let emitter = Emitter::point(position, intensity, range, emission).expect("finite numbers");
    match bytes.flag() {
        true => emitter.with_falloff(Falloff::Smooth),
        false => emitter.with_falloff(Falloff::Hard),
    }
}

fn medium(bytes: &mut Bytes<'_>) -> Medium {
    let phase = bytes.one_of(&[
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
        PhaseFunction::Rayleigh,
    ]);
    let sigma_t = bytes.magnitude(-12.0, 4.0);
    let albedo = bytes.one_of(&[1.0, 0.5, 0.0]);
    let [sigma_s, sigma_a] = [albedo, 1.0 - albedo].map(|share| Vec3::splat(share * sigma_t));
    let medium = Medium::new(sigma_s, sigma_a, phase).expect("coefficients");
    let [a, b] = [(); 2].map(|()| bytes.vector(SIZE));
    match bytes.flag().then(|| Bounds::new(a.min(b), a.max(b))) {
        Some(Ok(bounds)) => medium.within(bounds),
        _ => medium,
    }
}

/// Fog that thins out, on top of the medium of some rooms.
fn height_fog(bytes: &mut Bytes<'_>) -> Option<HeightFog> {
    if bytes.below(4) > 0 {
        return None;
    }
    let sigma_s = Vec3::splat(bytes.magnitude(-12.0, 4.0));
    let (altitude, height) = (bytes.between(-SIZE, SIZE), bytes.magnitude(-6.0, 6.0));
    let phase = PhaseFunction::Isotropic;
    let fog = HeightFog::new(sigma_s, Vec3::ZERO, altitude, height, phase);
    Some(fog.expect("coefficients"))
}

/// Whether a light certainly reaches a point of the fog, if nothing is in its way: found
/// point by point, and not next to any border.
fn reaches(emitter: &Emitter, medium: &Medium, at: Vec3) -> bool {
    const CLEAR: f32 = 1e-3;
    let is_inside = medium.bounds().is_none_or(|bounds| {
        let [min, max] = [bounds.min(), bounds.max()];
        (at - min).min_element() > CLEAR && (max - at).min_element() > CLEAR
    });
    let is_within = match emitter {
        Emitter::Directional(_) => true,
        Emitter::Point(point) => {
            let from_light = at - point.position();
            let distance = from_light.length();
            let way = from_light / distance;
            let in_cone = match point.emission() {
                Emission::Isotropic => true,
                Emission::Cosine { normal } => normal.dot(way) > CLEAR,
                Emission::Spot(spot) => spot.axis().dot(way) > spot.cos_outer() + CLEAR,
            };
            (CLEAR..point.range() * (1.0 - CLEAR)).contains(&distance) && in_cone
        }
    };
    is_inside && is_within && emitter.intensity() != Vec3::ZERO
}

/// Whether exact visibility sees all that the light reaches of every ray.
fn is_wholly_lit(rays: &[Ray], tracer: &Tracer, emitter: &Emitter, medium: &Medium) -> bool {
    rays.iter().all(|ray| {
        let Some(path) = LightPath::new(ray, emitter, medium) else {
            return true;
        };
        let mut lit: Vec<LitInterval<Vec3>> = Vec::new();
        Exact::new(tracer).lit_intervals(&path, &mut lit);
        matches!(lit[..], [part] if part.interval == path.span() && part.visibility == Vec3::ONE)
    })
}

/// A plan leaves out only lights that reach no ray, whose picture is black, and only the
/// shadows of lights that nothing is in the way of, whose picture without shadows is that
/// with them bit for bit. One light is looked at.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (eye, forward) = (bytes.vector(SIZE), bytes.direction());
    let camera = Camera::look_at(eye, eye + forward, bytes.between(0.01, 2.5));
    let medium = medium(&mut bytes);
    let height_fog = height_fog(&mut bytes);
    let (Ok(camera), Some(geometry)) = (camera, geometry(&mut bytes)) else {
        return;
    };
    let emitters: Vec<Emitter> = (0..1 + bytes.below(3))
        .map(|_| emitter(&mut bytes, eye))
        .collect();
    let tracer = Tracer::new(&geometry);
    let view = View::new(&Cpu::single_threaded(), &camera, &tracer, 3, 2).expect("a legal size");
    let tiny = Tiny {
        geometry: &geometry,
        camera: &camera,
        view: &view,
        medium: &medium,
        height_fog: height_fog.as_ref(),
        translucent: &[],
    };
    let plan = tiny
        .with_inputs(&emitters, |inputs| Plan::of_frame(&inputs))
        .expect("memory for a few triangles");
    let index = bytes.below(emitters.len());
    let emitter = &emitters[index];
    let image = |method: &Entry, quality| {
        let image = tiny.image(std::slice::from_ref(emitter), method, quality);
        image.expect("memory for a few triangles")
    };
    let (exact, quality, (closed, closed_quality)) = &*EXACT;
    let truth = match (&height_fog, METHODS.for_heterogeneous_media()) {
        (Some(_), Some(method)) => image(method, least(method)),
        _ => image(exact, *quality),
    };
    let is_sound = |value: &f32| value.is_finite() && *value >= 0.0;
    assert!(
        truth.iter().flatten().all(is_sound),
        "{truth:?} of {emitter:?}"
    );
    if !plan.emitters().contains(&index) {
        assert!(
            truth.iter().flatten().all(|value| *value == 0.0),
            "{emitter:?}"
        );
        // Fog that thins out may be too thin to scatter anything.
        let scatters = height_fog.is_none() && !medium.scatters_nothing();
        let is_seen = |ray: &Ray| {
            let length = ray.length().min(4.0 * SIZE);
            let mut at = (0..16).map(|i| ray.at((i as f32 + 0.5) / 16.0 * length));
            at.any(|at| reaches(emitter, &medium, at))
        };
        assert!(
            !(scatters && view.rays().iter().any(is_seen)),
            "{emitter:?} is seen"
        );
    }
    if plan.unshadowed().contains(&index) {
        assert!(
            is_wholly_lit(view.rays(), &tracer, emitter, &medium),
            "{emitter:?}"
        );
        assert_eq!(truth, image(closed, *closed_quality), "{emitter:?}");
    }
}

/// Rooms of every kind.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..32_u8)
        .map(|seed| {
            let mix = |i: u8| i.wrapping_mul(61) ^ seed.wrapping_mul(101).rotate_left(4);
            (0..220_u8).map(mix).collect()
        })
        .collect()
}
