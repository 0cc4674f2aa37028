//! Lights, media and maps as shaders see them.

use airlight::gpu::PhaseRecord;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::Emitter;
use crate::airlight::far_end;
use crate::scene::{Emission, Medium};

/// `light_Emitter` of `path.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct EmitterRecord {
    pub(super) position: Vec3,
    pub(super) kind: u32,
    pub(super) intensity: Vec3,
    pub(super) range: f32,
    pub(super) axis: Vec3,
    pub(super) emission: u32,
    pub(super) right: Vec3,
    pub(super) outer_versine: f32,
    pub(super) up: Vec3,
    pub(super) edge: f32,
    pub(super) cookie_width: u32,
    pub(super) cookie_height: u32,
    pub(super) tan_outer: f32,
    pub(super) fades: u32,
}

/// `light_Medium` of `path.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct MediumRecord {
    pub(super) sigma_s: Vec3,
    pub(super) phase: u32,
    pub(super) sigma_t: Vec3,
    pub(super) far_end: f32,
    pub(super) low: Vec3,
    pub(super) bounded: u32,
    pub(super) high: Vec3,
    pub(super) padding: u32,
    pub(super) phase_parameters: [f32; 4],
}

/// `Scene` of `gather.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Scene {
    pub(super) emitter: EmitterRecord,
    pub(super) medium: MediumRecord,
    pub(super) rays: u32,
    pub(super) first: u32,
    pub(super) joined: u32,
    pub(super) panes: u32,
}

pub(super) const POINT: u32 = 0;
pub(super) const DIRECTIONAL: u32 = 1;
pub(super) const ISOTROPIC: u32 = 0;
pub(super) const COSINE: u32 = 1;
pub(super) const SPOT: u32 = 2;

impl EmitterRecord {
    /// The light, and the texels of its cookie and of the cookie's mip levels.
    pub(crate) fn new(emitter: &Emitter) -> (Self, Vec<[f32; 4]>) {
        let mut record = Self {
            intensity: emitter.intensity(),
            ..Self::zeroed()
        };
        let point = match emitter {
            Emitter::Directional(sun) => {
                record.kind = DIRECTIONAL;
                record.position = sun.direction();
                return (record, Vec::new());
            }
            Emitter::Point(point) => point,
        };
        record.kind = POINT;
        record.position = point.position();
        record.range = point.range().min(f32::MAX);
        record.fades = u32::from(point.fades());
        let mut texels = Vec::new();
        match point.emission() {
            Emission::Isotropic => record.emission = ISOTROPIC,
            Emission::Cosine { normal } => {
                record.emission = COSINE;
                record.axis = *normal;
            }
            Emission::Spot(spot) => {
                record.emission = SPOT;
                record.axis = spot.axis();
                record.right = spot.rotation() * Vec3::X;
                record.up = spot.rotation() * Vec3::Y;
                record.outer_versine = spot.outer_versine();
                record.edge = spot.rim();
                record.tan_outer = spot.tan_outer().min(f32::MAX);
                if let Some(cookie) = spot.texture() {
                    record.cookie_width = cookie.width();
                    record.cookie_height = cookie.height();
                    texels = std::iter::once(cookie)
                        .chain(spot.mip_levels())
                        .flat_map(|level| level.texels())
                        .map(|texel| texel.extend(0.0).into())
                        .collect();
                }
            }
        }
        (record, texels)
    }
}

impl MediumRecord {
    pub(crate) fn new(medium: &Medium) -> Self {
        let phase = PhaseRecord::from(medium.phase());
        let (low, high) = match medium.bounds() {
            Some(bounds) => (bounds.min(), bounds.max()),
            None => (Vec3::ZERO, Vec3::ZERO),
        };
        Self {
            sigma_s: medium.sigma_s(),
            phase: phase.kind,
            sigma_t: medium.sigma_t(),
            far_end: far_end(medium),
            low,
            bounded: u32::from(medium.bounds().is_some()),
            high,
            padding: 0,
            phase_parameters: phase.parameters,
        }
    }
}

#[cfg(feature = "shadow-map")]
pub(crate) use map::{FaceRecord, PicturesRecord};

#[cfg(feature = "shadow-map")]
mod map {
    use bytemuck::{Pod, Zeroable};
    use glam::Vec3;

    use crate::scene::raster::{Face, Rays};

    /// `light_Face` of `map.wgsl`.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, Pod, Zeroable)]
    pub(crate) struct FaceRecord {
        pub(crate) origin: Vec3,
        pub(crate) tan: f32,
        pub(crate) right: Vec3,
        pub(crate) half_width: f32,
        pub(crate) up: Vec3,
        pub(crate) half_height: f32,
        pub(crate) forward: Vec3,
        pub(crate) padding: f32,
    }

    impl FaceRecord {
        pub(crate) fn new(face: &Face) -> Self {
            let (tan, half_width, half_height) = match face.rays {
                Rays::Parallel {
                    half_width,
                    half_height,
                } => (0.0, half_width, half_height),
                Rays::Central { tan } => (tan, 0.0, 0.0),
            };
            Self {
                origin: face.origin,
                tan,
                right: face.right,
                half_width,
                up: face.up,
                half_height,
                forward: face.forward,
                padding: 0.0,
            }
        }
    }

    /// `light_Pictures` of `place.wgsl`.
    #[repr(C)]
    #[derive(Debug, Clone, Copy, Pod, Zeroable)]
    pub(crate) struct PicturesRecord {
        pub(crate) faces: [FaceRecord; 6],
        pub(crate) face_count: u32,
        pub(crate) resolution: u32,
        pub(crate) padding_a: u32,
        pub(crate) padding_b: u32,
    }

    impl PicturesRecord {
        pub(crate) fn new(all: &[Face], resolution: u32) -> Self {
            let mut faces = [FaceRecord::zeroed(); 6];
            for (record, face) in faces.iter_mut().zip(all) {
                *record = FaceRecord::new(face);
            }
            Self {
                faces,
                face_count: all.len() as u32,
                resolution,
                padding_a: 0,
                padding_b: 0,
            }
        }
    }
}
