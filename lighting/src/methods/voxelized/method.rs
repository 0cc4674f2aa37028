//! Voxelized shadow volumes, made anew in every frame from shadow maps.

use std::sync::{Mutex, PoisonError};

use gpu_backend::Memory;

use super::{BuildVoxels, Detail, Eye, Resolution, VoxelShadow, VoxelVolume};
use crate::Touching;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, Role, SourceAbout, SourceOn,
    SourceQuality, Work,
};
use crate::shadow_map::RenderShadowMap;

const VOXELS: SourceQuality = SourceQuality {
    unit: "voxels per axis",
    qualities: &[64, 128, 256, 512, 1024],
    quick: &[64, 256],
    pictured: 256,
    usual: 512,
};

/// The largest number of voxels along a coordinate: a volume of 2 GiB.
const MAX_VOXELS: u32 = 4096;

/// A volume of `side` voxels along each coordinate, except that φ has at most 1024, rounded to
/// a multiple of 32.
fn resolution(side: u32) -> Result<Resolution, MethodError> {
    if side > MAX_VOXELS {
        return Err(MethodError::Quality {
            value: side,
            unit: VOXELS.unit,
            expected: format!("at most {MAX_VOXELS}"),
        });
    }
    let bits = side.next_multiple_of(32).min(1024);
    Resolution::new(side, side, bits).map_err(MethodError::resource("a volume of voxels"))
}

/// The voxels of every light, read in some detail.
#[derive(Debug, Clone, Copy)]
struct Volumes {
    name: &'static str,
    title: &'static str,
    detail: Detail,
}

/// Memory for one volume that is kept from frame to frame. All lights use it in turn; it is not
/// here while one of them does.
#[derive(Debug)]
struct Volume<M: Memory>(Mutex<Option<VoxelVolume<M>>>);

impl Volumes {
    /// Takes the volume of a size, whichever light used it last.
    fn take<B: BuildVoxels>(
        frame: &Frame<'_, B>,
        side: u32,
    ) -> Result<VoxelVolume<B::Memory>, MethodError> {
        let resolution = resolution(side)?;
        let new = || {
            VoxelVolume::new(frame.backend, resolution)
                .map_err(MethodError::resource("a volume of voxels"))
        };
        let kept = frame.store.get(
            "voxels",
            side,
            |_: &Volume<B::Memory>| 4 * (resolution.words() + resolution.light_rays()) as u64,
            || Ok(Volume(Mutex::new(Some(new()?)))),
        )?;
        let taken = kept.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        taken.map_or_else(new, Ok)
    }
}

impl LightSources for Volumes {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(VOXELS),
            touching: Touching::Apart,
            is_sampled: self.detail == Detail::Voxels,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, side: u32) -> Work {
        let lights = inputs.emitters.len() as f64;
        let side = f64::from(side);
        Work {
            // A lookup for each light ray, and a bit for each voxel, of which 32 are processed
            // at a time.
            per_frame: lights * (side.powi(2) + side.powi(3) / 32.0),
            per_ray: lights * side / 32.0,
            ..inputs.map_work()
        }
    }
}

impl<B: RenderShadowMap + BuildVoxels> SourceOn<B> for Volumes {
    type Source = VoxelShadow<VoxelVolume<B::Memory>, B::Memory>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, side: u32) -> Result<(), MethodError> {
        resolution(side)?;
        frame.shadow_map(light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        side: u32,
    ) -> Result<Self::Source, MethodError> {
        let FrameInputs {
            emitters,
            medium,
            camera,
            size,
            rays,
            ..
        } = frame.inputs;
        let map = frame.shadow_map(light)?;
        let mut volume = Self::take(frame, side)?;
        frame.pass("voxels", || {
            let eye = Eye::of_camera(camera, size, rays, medium);
            volume
                .update(frame.backend, &emitters[light], &eye, &map)
                .map_err(MethodError::resource("voxels"))
        })?;
        Ok(VoxelShadow::new(volume, self.detail))
    }

    fn done(&self, frame: &Frame<'_, B>, source: Self::Source, side: u32) {
        // Commands run in order, so the memory can be used again before they have run.
        let kept = frame.store.get(
            "voxels",
            side,
            |_: &Volume<B::Memory>| 0,
            || Ok(Volume(Mutex::default())),
        );
        if let Ok(kept) = kept {
            *kept.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(source.into_volume());
        }
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, detail, title, purpose, paper| Compared {
        airlight,
        detail: Some(detail),
        title,
        purpose,
        paper,
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    let mut all = pairs!(
        Volumes {
            name: "voxel-average",
            title: "voxelized shadow volumes, averaged",
            detail: Detail::Average,
        },
        &[compared(
            Role::Paper,
            "gauss",
            8,
            "voxelized shadow volumes, averaged",
            "least work per ray, at any number of blockers; its error has a floor",
            "Wyman, Voxelized Shadow Volumes, HPG 2011; the gather of Wyman and Dai, HPG 2013",
        )]
    );
    all.extend(pairs!(
        Volumes {
            name: "per-voxel",
            title: "voxelized shadow volumes, per voxel",
            detail: Detail::Voxels,
        },
        &[compared(
            Role::Variant,
            "gauss",
            1,
            "voxelized shadow volumes, per voxel",
            "the same bits with a weight each: no floor but that of the shadow map",
            "Wyman, Voxelized Shadow Volumes, HPG 2011",
        )]
    ));
    all.extend(pairs!(
        Volumes {
            name: "voxel-runs",
            title: "voxelized shadow volumes, lit runs",
            detail: Detail::Runs,
        },
        &[
            compared(
                Role::Variant,
                "gauss",
                8,
                "voxelized shadow volumes, lit runs",
                "the same bits by runs: any light, as few evaluations as can be",
                "Wyman, Voxelized Shadow Volumes, HPG 2011, for the bits",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "voxelized shadow volumes, airlight table",
                "point lights: one texel for the visibility of a ray, two lookups for a run",
                "Wyman, HPG 2011, for the bits; Sun et al., SIGGRAPH 2005, for the integral",
            ),
        ]
    ));
    all
}
