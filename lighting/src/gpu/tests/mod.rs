//! Shaders without a device, and steps against the CPU with one.

#[cfg(feature = "shadow-map")]
mod agreement;
#[cfg(all(feature = "shadow-map", feature = "trace"))]
mod exact;
#[cfg(feature = "shadow-map")]
mod hybrids;
#[cfg(feature = "voxel-shadow")]
mod many_maps;
#[cfg(feature = "shadow-map")]
mod maps;
#[cfg(feature = "shadow-map")]
mod scenes;
#[cfg(feature = "shadow-map")]
mod textured;
#[cfg(feature = "translucent")]
mod translucent;

use ::airlight::gpu::PHASE;
use ::airlight::{FrameTable, Table};
use glam::Vec3;
use gpu_backend::assert_same_layout;
use gpu_backend::gpu::InShader;
use gpu_backend::testing::Shader;

use super::gather::shader;
use super::scene::{self, EmitterRecord, MediumRecord, Scene};
use super::*;
use crate::Ray;
use crate::airlight::{Analytic, Daylight, EquiAngular, Midpoint, PerFrame, Quadrature};
use crate::visibility::Unshadowed;

/// Stands for the entry point.
const CONTRACT: &str = "
    fn light_emitter() -> light_Emitter { return light_Emitter(); }
    fn light_medium() -> light_Medium { return light_Medium(); }
    fn light_cookie(index: u32) -> vec3<f32> { return vec3(f32(index)); }";

fn path_shader() -> Shader {
    Shader::new(&[NUMERIC, PHASE, PATH, ARC, DIRECTIONAL, LIT, CONTRACT]).unwrap()
}

/// The shader of a pair, which must be valid and keep to WebGPU's eight storage
/// buffers, of which the frame has three.
fn complete<V: InShader<VisibilitySlot>, A: InShader<AirlightSlot>>() -> Shader {
    let assembly = shader::<V, A>().unwrap();
    let storage = assembly.bindings().iter().filter(|b| b.kind.is_storage());
    let storage = 3 + storage.count();
    assert!(storage <= 8, "{storage} storage buffers");
    let parts = assembly.finish(1);
    let groups = (0..4).filter(|g| parts.iter().any(|p| p.contains(&format!("@group({g})"))));
    assert!(groups.eq(0..2) || parts.iter().all(|p| !p.contains("@group(1)")));
    Shader::new(&parts).unwrap()
}

#[test]
fn all_parts_are_fit_for_other_shaders() {
    path_shader().require_part(&["light_", "air_"]).unwrap();
}

#[test]
fn shaders_see_rays_as_they_are() {
    // The fields of a ray are its own business; its bytes are not.
    let origin = Vec3::new(1.0, 2.0, 3.0);
    let ray = Ray::new(origin, Vec3::NEG_Y, 5.0).unwrap();
    let words: [f32; 8] = bytemuck::cast(ray);
    let at = |first: f32| 4 * words.iter().position(|word| *word == first).unwrap();
    let direction = 4 * words.iter().position(|word| *word == -1.0).unwrap() - 4;
    let fields = [
        ("origin", at(1.0)),
        ("length", at(5.0)),
        ("direction", direction),
        ("padding", 28),
    ];
    assert_eq!(words[direction / 4..][..3], [0.0, -1.0, 0.0]);
    assert_eq!(words[at(1.0) / 4..][..3], origin.to_array());
    path_shader()
        .same_layout("light_Ray", size_of::<Ray>(), &fields)
        .unwrap();
}

#[test]
fn every_pair_compiles() {
    complete::<Unshadowed, Midpoint>();
    complete::<Unshadowed, EquiAngular>();
    complete::<Unshadowed, Quadrature>();
    complete::<Unshadowed, Analytic<Table>>();
    complete::<Unshadowed, Daylight>();
    let per_frame = complete::<Unshadowed, PerFrame>();
    let deepest = per_frame.values("light_FRAME_DEEPEST").unwrap();
    assert_eq!(deepest, [f64::from(FrameTable::DEEPEST)]);
}

#[cfg(feature = "shadow-map")]
#[test]
fn marches_compile_with_every_evaluator_and_see_their_map_as_it_is() {
    use gpu_backend::gpu::GpuMemory;

    use super::scene::{FaceRecord, PicturesRecord};
    use crate::methods::march::gpu::MarchRecord;
    use crate::methods::slices::Slices;
    use crate::methods::slices::gpu::SlicesRecord;
    use crate::shadow_map::ShadowMap;
    use crate::visibility::March;

    complete::<March<ShadowMap<GpuMemory>>, Midpoint>();
    let shader = complete::<March<ShadowMap<GpuMemory>>, EquiAngular>();
    let sliced = complete::<Slices<ShadowMap<GpuMemory>>, Midpoint>();
    assert_same_layout!(
        sliced,
        "light_Slices",
        SlicesRecord {
            forward,
            thickness,
            count,
            near,
            padding_a,
            padding_b
        }
    );
    assert_same_layout!(
        shader,
        "light_March",
        MarchRecord {
            steps,
            spacing,
            stride,
            each
        }
    );
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
        "light_Pictures",
        PicturesRecord {
            faces,
            face_count,
            resolution,
            padding_a,
            padding_b
        }
    );
}

#[cfg(feature = "shadow-map")]
#[test]
fn hybrids_compile_with_every_evaluator_and_count_as_the_cpu_does() {
    use gpu_backend::gpu::GpuMemory;

    use crate::methods::hybrid::gpu::{CONSTANTS, CellsRecord, FAR, HybridRecord};
    use crate::methods::hybrid::{FilteredHybrid, Hybrid};
    use crate::methods::prefiltered::MomentPyramid;
    use crate::methods::prefiltered::gpu::PyramidRecord;
    use crate::shadow_map::ShadowMap;

    type Source = Hybrid<ShadowMap<GpuMemory>, GpuMemory>;
    complete::<Source, Midpoint>();
    complete::<Source, Quadrature>();
    complete::<Source, Analytic<Table>>();
    type Filtered = FilteredHybrid<MomentPyramid<GpuMemory>, GpuMemory>;
    complete::<Filtered, Midpoint>();
    complete::<Filtered, Quadrature>();
    complete::<Filtered, EquiAngular>();
    complete::<Filtered, PerFrame>();
    let shader = complete::<Source, EquiAngular>();
    assert_same_layout!(
        shader,
        "light_Hybrid",
        HybridRecord {
            steps,
            cell,
            side,
            by_span,
            has_shadow,
            has_light,
            padding_a,
            padding_b
        }
    );
    let far = Shader::new(&FAR).unwrap();
    assert_same_layout!(
        far,
        "Cells",
        CellsRecord {
            pictures,
            cell,
            side,
            margin,
            level,
            factor,
            more,
            most,
            padding
        }
    );
    let filtered = complete::<Filtered, Analytic<Table>>();
    assert_same_layout!(
        filtered,
        "light_Pyramid",
        PyramidRecord {
            firsts,
            count,
            padding_a,
            padding_b,
            padding_c
        }
    );
    for (name, value) in CONSTANTS {
        let found = shader.values(name).unwrap();
        assert_eq!(found.len(), 1);
        assert!(
            (found[0] - value).abs() <= 1e-6 * value,
            "{name}: {found:?}"
        );
    }
}

#[cfg(feature = "translucent")]
#[test]
fn marches_through_transmittance_compile_with_every_evaluator() {
    use gpu_backend::gpu::GpuMemory;

    use crate::translucent::TransmittanceMap;
    use crate::visibility::March;

    complete::<March<TransmittanceMap<GpuMemory>>, Midpoint>();
    complete::<March<TransmittanceMap<GpuMemory>>, EquiAngular>();
    complete::<March<TransmittanceMap<GpuMemory>>, Quadrature>();
    complete::<March<TransmittanceMap<GpuMemory>>, Analytic<Table>>();
}

#[cfg(feature = "voxel-shadow")]
#[test]
fn voxels_compile_with_every_evaluator_and_are_seen_as_they_are() {
    use gpu_backend::gpu::{GpuMemory, INDEX_WGSL};
    use gpu_backend::shader::Assembly;
    use voxel_shadow::gpu::FirstBlockerSlot;

    use crate::methods::voxelized::gpu::VoxelRecord;
    use crate::shadow_map::ShadowMap;
    use crate::voxelized::{VoxelShadow, VoxelVolume};

    type Voxels = VoxelShadow<VoxelVolume<GpuMemory>, GpuMemory>;
    complete::<Voxels, EquiAngular>();
    complete::<Voxels, Quadrature>();
    complete::<Voxels, Analytic<Table>>();
    let shader = complete::<Voxels, Midpoint>();
    assert_same_layout!(
        shader,
        "light_Voxels",
        VoxelRecord {
            lattice,
            sampling,
            detail,
            state
        }
    );
    let mut blocker = Assembly::new(&[INDEX_WGSL]);
    let part = <ShadowMap<GpuMemory> as InShader<FirstBlockerSlot>>::part();
    blocker.fill::<FirstBlockerSlot>(&part).unwrap();
    let shader = Shader::new(&blocker.finish(1)).unwrap();
    let empty = f64::from(crate::shadow_map::EMPTY);
    assert_eq!(shader.values("light_EMPTY").unwrap(), [empty]);
}

#[cfg(feature = "shadow-dag")]
#[test]
fn baked_shadows_compile_with_every_evaluator_and_are_seen_as_they_are() {
    use crate::methods::precomputed::gpu::{BakedRecord, GridRecord};

    type Shadow = crate::precomputed::BakedShadow<gpu_backend::gpu::GpuMemory>;

    complete::<Shadow, Midpoint>();
    complete::<Shadow, Quadrature>();
    complete::<Shadow, Analytic<Table>>();
    let shader = complete::<Shadow, EquiAngular>();
    assert_same_layout!(shader, "light_BakedGrid", GridRecord { dag, space });
    assert_same_layout!(shader, "light_Baked", BakedRecord { grids, count, bias });
}

/// Every source with every evaluator, and every two sources that can meet.
#[cfg(all(
    feature = "shadow-dag",
    feature = "translucent",
    feature = "voxel-shadow"
))]
#[test]
fn every_combination_keeps_to_eight_storage_buffers_and_two_groups() {
    use gpu_backend::gpu::GpuMemory;

    use crate::methods::epipolar::MapRuns;
    use crate::methods::light_volumes::LightVolume;
    use crate::methods::prefiltered::PrefilteredMap;
    use crate::precomputed::BakedShadow;
    use crate::shadow_map::ShadowMap;
    use crate::translucent::TransmittanceMap;
    use crate::visibility::{Both, March};
    use crate::voxelized::{VoxelShadow, VoxelVolume};

    type Voxels = VoxelShadow<VoxelVolume<GpuMemory>, GpuMemory>;
    type Baked = BakedShadow<GpuMemory>;
    type Map = March<ShadowMap<GpuMemory>>;
    type Curves = March<TransmittanceMap<GpuMemory>>;
    type Runs = MapRuns<ShadowMap<GpuMemory>, GpuMemory>;
    type Lit = LightVolume<GpuMemory>;
    type Together = March<Both<ShadowMap<GpuMemory>, TransmittanceMap<GpuMemory>>>;
    type Filtered = March<PrefilteredMap<GpuMemory>>;

    fn with_every_evaluator<V: InShader<VisibilitySlot>>() {
        complete::<V, Midpoint>();
        complete::<V, EquiAngular>();
        complete::<V, Quadrature>();
        complete::<V, Analytic<Table>>();
        complete::<V, PerFrame>();
        complete::<V, Daylight>();
    }

    #[cfg(feature = "trace")]
    with_every_evaluator::<crate::methods::exact::UploadedTracer>();
    with_every_evaluator::<Unshadowed>();
    with_every_evaluator::<Map>();
    with_every_evaluator::<Curves>();
    with_every_evaluator::<Voxels>();
    with_every_evaluator::<Baked>();
    with_every_evaluator::<Runs>();
    with_every_evaluator::<Lit>();
    with_every_evaluator::<Filtered>();
    with_every_evaluator::<Both<Baked, Filtered>>();
    with_every_evaluator::<Both<Voxels, Baked>>();
    with_every_evaluator::<Both<Baked, Runs>>();
    with_every_evaluator::<Both<Runs, Curves>>();
    with_every_evaluator::<Both<Baked, Lit>>();
    with_every_evaluator::<Both<Lit, Curves>>();
    with_every_evaluator::<Both<Voxels, Map>>();
    with_every_evaluator::<Both<Baked, Map>>();
    with_every_evaluator::<Both<Voxels, Curves>>();
    with_every_evaluator::<Both<Baked, Curves>>();
    with_every_evaluator::<Together>();
    with_every_evaluator::<Both<Baked, Together>>();
    let twice = shader::<Both<Map, Curves>, Midpoint>().unwrap_err();
    assert!(twice.to_string().contains("light_march"), "{twice}");
}

#[cfg(feature = "shadow-map")]
#[test]
fn shaders_see_the_runs_of_a_map_as_they_are() {
    use gpu_backend::gpu::GpuMemory;

    use crate::methods::epipolar::{MapRuns, gpu::RunsRecord};
    use crate::shadow_map::ShadowMap;

    let shader = complete::<MapRuns<ShadowMap<GpuMemory>, GpuMemory>, Midpoint>();
    assert_same_layout!(
        shader,
        "light_Runs",
        RunsRecord {
            pictures,
            fans,
            eye,
            padding
        }
    );
}

#[cfg(feature = "shadow-map")]
#[test]
fn shaders_see_light_volumes_as_they_are() {
    use gpu_backend::gpu::GpuMemory;

    use crate::methods::light_volumes::{LightVolume, gpu::VolumeRecord};

    let shader = complete::<LightVolume<GpuMemory>, Midpoint>();
    assert_same_layout!(shader, "light_Volume", VolumeRecord { pictures, mesh });
}

#[cfg(feature = "shadow-map")]
#[test]
fn the_shaders_of_shadow_maps_compile_and_see_their_tile_as_it_is() {
    use super::shadow_map::{COPY, RENDER, Tile};

    for parts in [&RENDER[..], &COPY] {
        let shader = Shader::new(parts).unwrap();
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
                near,
                solid,
                padding,
                more_padding
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
            outer_versine,
            up,
            edge,
            cookie_width,
            cookie_height,
            tan_outer,
            fades,
        }
    );
    assert_same_layout!(
        shader,
        "light_Medium",
        MediumRecord {
            sigma_s,
            phase,
            sigma_t,
            far_end,
            low,
            bounded,
            high,
            padding,
            phase_parameters,
        }
    );
    assert_same_layout!(
        shader,
        "Scene",
        Scene {
            emitter,
            medium,
            rays,
            first,
            joined,
            panes,
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
    let cookies = complete::<Unshadowed, Quadrature>();
    assert_eq!(
        cookies.values("light_MOST_COOKIE_LINES").unwrap(),
        [f64::from(crate::scene::MOST_COOKIE_LINES)]
    );
    assert_eq!(shader.values("light_FAR").unwrap(), [f64::from(f32::MAX)]);
    let pi = f64::from(std::f32::consts::PI);
    assert_eq!(shader.values("light_PI").unwrap(), [pi]);
}
