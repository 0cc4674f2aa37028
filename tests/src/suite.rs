//! One test body for every backend.

use airlight::Table;
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Cpu, Download, testing};
use lighting::Gather;
use lighting::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use lighting::methods::MethodBackend;
use lighting::shadow_map::{RenderShadowMap, ShadowMap};
use lighting::visibility::{March, Unshadowed};
use lighting::voxelized::{BuildVoxels, VoxelShadow, VoxelVolume};

/// What a backend must be able to do to be tested: every step there is but
/// exact visibility, whose source is of another type on each backend.
pub trait Subject:
    Download
    + MethodBackend
    + RenderShadowMap
    + BuildVoxels
    + Gather<Unshadowed, Midpoint>
    + Gather<Unshadowed, EquiAngular>
    + Gather<Unshadowed, Quadrature>
    + Gather<Unshadowed, Analytic<Table>>
    + for<'a> Gather<March<&'a ShadowMap<<Self as Backend>::Memory>>, Midpoint>
    + for<'a> Gather<March<&'a ShadowMap<<Self as Backend>::Memory>>, EquiAngular>
    + for<'a> Gather<
        VoxelShadow<&'a VoxelVolume<<Self as Backend>::Memory>, <Self as Backend>::Memory>,
        Quadrature,
    > + for<'a> Gather<
        VoxelShadow<&'a VoxelVolume<<Self as Backend>::Memory>, <Self as Backend>::Memory>,
        EquiAngular,
    >
{
}

impl<B> Subject for B where
    B: Download
        + MethodBackend
        + RenderShadowMap
        + BuildVoxels
        + Gather<Unshadowed, Midpoint>
        + Gather<Unshadowed, EquiAngular>
        + Gather<Unshadowed, Quadrature>
        + Gather<Unshadowed, Analytic<Table>>
        + for<'a> Gather<March<&'a ShadowMap<<B as Backend>::Memory>>, Midpoint>
        + for<'a> Gather<March<&'a ShadowMap<<B as Backend>::Memory>>, EquiAngular>
        + for<'a> Gather<
            VoxelShadow<&'a VoxelVolume<<B as Backend>::Memory>, <B as Backend>::Memory>,
            Quadrature,
        > + for<'a> Gather<
            VoxelShadow<&'a VoxelVolume<<B as Backend>::Memory>, <B as Backend>::Memory>,
            EquiAngular,
        >
{
}

/// One thread.
pub fn cpu_alone() -> Option<Cpu> {
    Some(Cpu::single_threaded())
}

/// Three threads: results must be the same as with one.
pub fn cpu_with_threads() -> Option<Cpu> {
    Some(Cpu::with_threads(3).expect("three threads"))
}

/// The GPU, if there is one; see [`testing::gpu`].
pub fn gpu() -> Option<Gpu<Queued>> {
    testing::gpu()
}

/// Makes a test of each body for each backend. A body is a function
/// `fn name<B: Subject>(backend: &B)`.
///
/// This is the one place where backends are listed; a new one is a new line
/// `module => constructor` below. `heavy` bodies leave out the single thread,
/// and `traced` ones the GPU.
#[macro_export]
macro_rules! on_every_backend {
    (heavy: $($body:ident),+ $(,)?) => {
        $crate::on_every_backend! { @for [$($body),+]
            heavy_on_cpu => $crate::suite::cpu_with_threads,
            heavy_on_gpu => $crate::suite::gpu,
        }
    };
    (traced: $($body:ident),+ $(,)?) => {
        $crate::on_every_backend! { @for [$($body),+]
            traced_alone => $crate::suite::cpu_alone,
            traced_with_threads => $crate::suite::cpu_with_threads,
        }
    };
    ($($body:ident),+ $(,)?) => {
        $crate::on_every_backend! { @for [$($body),+]
            cpu_alone => $crate::suite::cpu_alone,
            cpu_with_threads => $crate::suite::cpu_with_threads,
            gpu => $crate::suite::gpu,
        }
    };
    (@for $bodies:tt $($backend:ident => $new:path,)+) => {
        $($crate::on_every_backend! { @module $backend $new, $bodies })+
    };
    (@module $backend:ident $new:path, [$($body:ident),+]) => {
        mod $backend {
            $(
                #[test]
                fn $body() {
                    if let Some(backend) = $new() {
                        super::$body(&backend);
                    }
                }
            )+
        }
    };
}
