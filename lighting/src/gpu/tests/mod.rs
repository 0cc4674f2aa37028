//! Shaders without a device, and steps against the CPU with one.

#[cfg(feature = "march")]
mod agreement;
#[cfg(feature = "march")]
mod maps;
#[cfg(feature = "march")]
mod scenes;
#[cfg(feature = "translucent")]
mod translucent;

use ::airlight::Table;
use ::airlight::gpu::PHASE;
use gpu_backend::assert_same_layout;
use gpu_backend::testing::Shader;

use super::gather::parts;
use super::scene::{self, EmitterRecord, MediumRecord, Scene};
use super::*;
use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use crate::visibility::{MergeTouching, Unshadowed};

/// Stands for the entry point.
const CONTRACT: &str = "
    fn light_emitter() -> light_Emitter { return light_Emitter(); }
    fn light_medium() -> light_Medium { return light_Medium(); }
    fn light_slide(index: u32) -> vec3<f32> { return vec3(f32(index)); }";

pub(crate) fn path_shader() -> Shader {
    Shader::new(&[NUMERIC, PHASE, PATH, ARC, DIRECTIONAL, LIT, CONTRACT]).unwrap()
}

fn complete<V: WgslVisibility, A: WgslAirlight>() -> Shader {
    let shader = Shader::new(&parts::<V, A>()).unwrap();
    for merge in [0.0, 1.0] {
        shader.specialise(&[("MERGE", merge)]).unwrap();
    }
    shader
}

#[test]
fn all_parts_are_fit_for_other_shaders() {
    path_shader().require_part(&["light_", "air_"]).unwrap();
}

#[test]
fn every_pair_compiles() {
    complete::<Unshadowed, Midpoint>();
    complete::<Unshadowed, EquiAngular>();
    complete::<MergeTouching<Unshadowed>, EquiAngular>();
    complete::<Unshadowed, Quadrature>();
    complete::<Unshadowed, Analytic<Table>>();
    let merge = MergeTouching(Unshadowed).constants();
    assert_eq!(merge, [("MERGE", 1.0)]);
}

#[cfg(feature = "march")]
#[test]
fn marches_compile_with_every_evaluator_and_see_their_map_as_it_is() {
    use gpu_backend::gpu::GpuMemory;

    use super::scene::{FaceRecord, Map};
    use crate::visibility::ShadowMapMarch;

    complete::<ShadowMapMarch<'_, GpuMemory>, Midpoint>();
    let shader = complete::<ShadowMapMarch<'_, GpuMemory>, EquiAngular>();
    assert_same_layout!(
        shader,
        "light_Face",
        FaceRecord {
            origin,
            tan,
            right,
            half_width,
            up,
            half_height,
            forward,
            padding
        }
    );
    assert_same_layout!(
        shader,
        "Map",
        Map {
            faces,
            face_count,
            resolution,
            samples,
            equi_angular
        }
    );
}

#[cfg(feature = "translucent")]
#[test]
fn marches_through_transmittance_compile_with_every_evaluator() {
    use gpu_backend::gpu::GpuMemory;

    use crate::translucent::StoredMap;
    use crate::visibility::TransmittanceMarch;

    complete::<TransmittanceMarch<'_, StoredMap<GpuMemory>>, Midpoint>();
    complete::<TransmittanceMarch<'_, StoredMap<GpuMemory>>, EquiAngular>();
    complete::<TransmittanceMarch<'_, StoredMap<GpuMemory>>, Quadrature>();
    complete::<MergeTouching<TransmittanceMarch<'_, StoredMap<GpuMemory>>>, Analytic<Table>>();
}

#[cfg(feature = "voxel-shadow")]
#[test]
fn voxels_compile_with_every_evaluator_and_are_seen_as_they_are() {
    use gpu_backend::gpu::{GpuMemory, INDEX_WGSL};
    use voxel_shadow::gpu::WgslFirstBlocker;

    use super::voxels::VoxelRecord;
    use crate::shadow_map::ShadowMap;
    use crate::voxels::VoxelShadow;

    complete::<VoxelShadow<'_, GpuMemory>, EquiAngular>();
    complete::<VoxelShadow<'_, GpuMemory>, Quadrature>();
    complete::<VoxelShadow<'_, GpuMemory>, Analytic<Table>>();
    let shader = complete::<VoxelShadow<'_, GpuMemory>, Midpoint>();
    assert_same_layout!(
        shader,
        "Voxels",
        VoxelRecord {
            lattice,
            sampling,
            detail,
            state
        }
    );
    let blocker = <ShadowMap<GpuMemory> as WgslFirstBlocker>::parts();
    let shader = Shader::new(&[&[INDEX_WGSL], blocker].concat()).unwrap();
    let empty = f64::from(crate::shadow_map::EMPTY);
    assert_eq!(shader.values("light_EMPTY").unwrap(), [empty]);
}

#[cfg(feature = "shadow-dag")]
#[test]
fn baked_shadows_compile_with_every_evaluator_and_are_seen_as_they_are() {
    use super::baked::{BakedRecord, GridRecord};

    type Shadow = crate::precomputed::BakedShadow<gpu_backend::gpu::GpuMemory>;

    complete::<Shadow, Midpoint>();
    complete::<Shadow, Quadrature>();
    complete::<Shadow, Analytic<Table>>();
    let shader = complete::<Shadow, EquiAngular>();
    assert_same_layout!(shader, "BakedGrid", GridRecord { dag, space });
    assert_same_layout!(shader, "Baked", BakedRecord { grids, count });
}

#[cfg(feature = "march")]
#[test]
fn the_shaders_of_shadow_maps_compile_and_see_their_tile_as_it_is() {
    use super::shadow_map::{COPY, RENDER, Tile};

    for parts in [RENDER, COPY] {
        let shader = Shader::new(&parts).unwrap();
        assert_same_layout!(
            shader,
            "Tile",
            Tile {
                face,
                scale,
                offset,
                first,
                size,
                resolution,
                index,
                far,
                near
            }
        );
    }
}

#[test]
fn structures_and_constants_are_those_of_rust() {
    let shader = complete::<Unshadowed, Midpoint>();
    assert_same_layout!(
        shader,
        "light_Emitter",
        EmitterRecord {
            position,
            kind,
            intensity,
            range,
            axis,
            emission,
            right,
            cos_outer,
            up,
            edge,
            slide_width,
            slide_height,
            tan_outer,
            padding,
        }
    );
    assert_same_layout!(
        shader,
        "light_Medium",
        MediumRecord {
            sigma_s,
            phase,
            sigma_t,
            phase_parameter,
            low,
            bounded,
            high,
            far_end,
        }
    );
    assert_same_layout!(
        shader,
        "Scene",
        Scene {
            emitter,
            medium,
            rays,
            padding_a,
            padding_b,
            padding_c,
        }
    );
    let constant = |name: &str, value: u32| {
        assert_eq!(shader.values(name).unwrap(), [f64::from(value)], "{name}");
    };
    constant("light_POINT", scene::POINT);
    constant("light_DIRECTIONAL", scene::DIRECTIONAL);
    constant("light_ISOTROPIC", scene::ISOTROPIC);
    constant("light_COSINE", scene::COSINE);
    constant("light_SPOT", scene::SPOT);
    assert_eq!(shader.values("light_FAR").unwrap(), [f64::from(f32::MAX)]);
    let pi = f64::from(std::f32::consts::PI);
    assert_eq!(shader.values("light_PI").unwrap(), [pi]);
}
