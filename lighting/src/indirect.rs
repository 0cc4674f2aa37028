//! Light of a view that comes neither directly from a lamp nor by single scattering in the air
//! in front of a surface: light that fog scatters onto surfaces, light of an environment, and
//! uniform light that the fog scatters into the eye.
//!
//! [`radiance`] combines [`surface_scattering`](crate::surface_scattering) and
//! [`environment`](crate::environment), on any backend.

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Download, Error};

use crate::environment::{AddEnvironment, Ambient, Environment, EnvironmentError, EnvironmentMap};
use crate::scene::trace::Tracer;
use crate::scene::view::View;
use crate::scene::{Geometry, Medium, Scene};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap, ShadowMapError};
use crate::surface_scattering::{AddSurfaceScattering, ClosedForm, LitSurfaces, Quadrature};
use crate::visibility::Unshadowed;
use crate::{Emitter, surface};

/// What a backend has to implement for [`radiance`]. All backends of this workspace do.
pub trait LightSurfaces:
    Download
    + AddEnvironment
    + RenderShadowMap
    + AddSurfaceScattering<ClosedForm>
    + AddSurfaceScattering<Quadrature<Unshadowed>>
    + for<'a> AddSurfaceScattering<Quadrature<&'a ShadowMap<<Self as Backend>::Memory>>>
{
}

impl<B> LightSurfaces for B where
    B: Download
        + AddEnvironment
        + RenderShadowMap
        + AddSurfaceScattering<ClosedForm>
        + AddSurfaceScattering<Quadrature<Unshadowed>>
        + for<'a> AddSurfaceScattering<Quadrature<&'a ShadowMap<<B as Backend>::Memory>>>
{
}

/// A view, with the scene that it shows.
#[derive(Debug, Clone, Copy)]
pub struct LitView<'a> {
    /// The rays and what they meet.
    pub view: &'a View,
    /// The scene that the view was made from.
    pub scene: &'a Scene,
    /// Its triangles.
    pub geometry: &'a Geometry,
    /// The same triangles, arranged for tracing.
    pub tracer: &'a Tracer,
    /// The lights.
    pub emitters: &'a [Emitter],
    /// The fog; `None` is a vacuum.
    pub medium: Option<&'a Medium>,
}

/// The shadows in the fog from which light is scattered onto surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FogShadows {
    /// No shadows, as in the paper; in closed form where there is one.
    None,
    /// From shadow maps that are rendered for this purpose.
    Maps {
        /// Texels per side.
        resolution: u32,
    },
}

/// The kinds of light that are added to a view.
#[derive(Debug, Clone, Copy)]
pub struct IndirectLight<'a> {
    /// Light that the fog scatters onto surfaces; `None` leaves it out.
    pub scattering: Option<FogShadows>,
    /// Nodes of the quadrature where there is no closed form; see [`Quadrature`].
    pub nodes: u32,
    /// Light from an environment, if there is one.
    pub environment: Option<&'a Environment>,
    /// Uniform radiance from all directions that the fog in front of surfaces scatters into the
    /// eye; also in front of the sky, unless an environment has its own halo there. See
    /// [`Ambient`].
    pub ambient: Option<[f32; 3]>,
    /// Rays per surface that find the share of the environment that it sees; see
    /// [`surface::with_openness`]. With 0 every surface sees all of it.
    pub openness_rays: u32,
}

/// Why the light could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IndirectError {
    /// The environment does not fit the fog, or not into memory.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// A shadow map could not be rendered.
    #[error(transparent)]
    ShadowMap(#[from] ShadowMapError),
    /// The number of nodes is out of range.
    #[error(transparent)]
    Nodes(#[from] airlight::Error),
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] Error),
}

/// Light of a view, and how it was computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Indirect {
    /// One RGB0 per ray.
    pub radiance: Vec<[f32; 4]>,
    /// Number of lights whose scattered light came from the closed form.
    pub in_closed_form: usize,
    /// Number of lights whose scattered light took a quadrature.
    pub by_quadrature: usize,
}

/// The light of `light` that is added to a view: to its surfaces, to the see-through surfaces
/// in front of them, and to the sky as far as these let its light through. Surfaces are found
/// on the CPU, and their light is computed on `backend`.
///
/// # Errors
/// [`IndirectError`] if something does not fit together, or does not fit into memory.
pub fn radiance<B: LightSurfaces>(
    backend: &B,
    cpu: &Cpu,
    lit: LitView<'_>,
    light: IndirectLight<'_>,
) -> Result<Indirect, IndirectError> {
    let LitView { view, .. } = lit;
    let mut points = surface::points(cpu, view, lit.scene, lit.geometry, lit.medium);
    let panes = surface::points_of_panes(cpu, view, lit.scene, lit.geometry, lit.medium);
    points.extend(panes.iter().map(|(_, point)| *point));
    if light.environment.is_some() && light.openness_rays > 0 {
        points = surface::with_openness(cpu, &points, lit.tracer, light.openness_rays);
    }
    let points = backend.upload(&points)?;
    let mut sum = backend.zeros::<[f32; 4]>(view.rays().len() + panes.len())?;
    let mut sky = None;
    let (mut in_closed_form, mut by_quadrature) = (0, 0);
    if let (Some(shadows), Some(medium)) = (light.scattering, lit.medium)
        && !medium.scatters_nothing()
    {
        let closed_form = ClosedForm::new(medium);
        let open = Quadrature::new(Unshadowed, light.nodes)?;
        let casters = match shadows {
            FogShadows::None => None,
            FogShadows::Maps { resolution } => {
                Some((Casters::upload(backend, lit.geometry)?, resolution))
            }
        };
        for emitter in lit.emitters {
            let lit = LitSurfaces {
                points: &points,
                emitter,
                medium,
            };
            if let Some((casters, resolution)) = &casters {
                let map = backend.shadow_map(casters, emitter, *resolution)?;
                let shadowed = Quadrature::new(&map, light.nodes)?;
                backend.add_surface_scattering(&lit, &shadowed, &mut sum)?;
                by_quadrature += 1;
            } else if closed_form.covers(emitter, medium).is_ok() {
                backend.add_surface_scattering(&lit, &closed_form, &mut sum)?;
                in_closed_form += 1;
            } else {
                backend.add_surface_scattering(&lit, &open, &mut sum)?;
                by_quadrature += 1;
            }
        }
    }
    if let Some(environment) = light.environment {
        let map = EnvironmentMap::new(backend, environment, lit.medium)?;
        let rays = backend.upload(view.rays())?;
        let mut behind = backend.zeros::<[f32; 4]>(view.rays().len())?;
        backend.add_sky(&rays, &map, &mut behind)?;
        backend.add_environment_light(&points, &map, &mut sum)?;
        sky = Some(backend.download(&behind)?);
    }
    let mut scattered = None;
    if let (Some(radiance), Some(medium)) = (light.ambient, lit.medium) {
        let mut ambient = Ambient::new(radiance, medium)?;
        if light.environment.is_some() {
            ambient = ambient.before_surfaces();
        }
        let rays = backend.upload(view.rays())?;
        let mut sum = backend.zeros::<[f32; 4]>(view.rays().len())?;
        backend.add_ambient(&rays, &ambient, &mut sum)?;
        scattered = Some(backend.download(&sum)?);
    }
    let mut radiance = backend.download(&sum)?;
    let of_panes = radiance.split_off(view.rays().len());
    let mut add = |pixel: usize, light: [f32; 4], share: Vec3| {
        for channel in 0..3 {
            radiance[pixel][channel] += share[channel] * light[channel];
        }
    };
    for ((pixel, _), light) in panes.iter().zip(of_panes) {
        add(*pixel, light, Vec3::ONE);
    }
    for (pixel, light) in scattered.into_iter().flatten().enumerate() {
        add(pixel, light, Vec3::ONE);
    }
    for (pixel, light) in sky.into_iter().flatten().enumerate() {
        let cover = view.cover().share(pixel, f32::INFINITY);
        add(pixel, light, cover * view.through_panes(pixel));
    }
    Ok(Indirect {
        radiance,
        in_closed_form,
        by_quadrature,
    })
}
