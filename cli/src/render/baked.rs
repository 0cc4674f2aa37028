//! The light of surfaces whose shadows are in files.

use gpu_backend::gpu::Gpu;
use gpu_backend::{Backend, Cpu, Download};
use lighting::Emitter;
use lighting::culling::PointLists;
use lighting::direct_light::{AddDirectLight, LitPoints};
use lighting::precomputed::{BakedShadow, BakedShadows, FilterSize};
use lighting::scene::view::View;
use lighting::shadow_map::{Casters, MapsOfMany, RenderShadowMap};
use lighting::surface::{self, Lit};
use lighting::translucent::TransmittanceMap;
use lighting::visibility::{Both, SurfaceShadow};

use crate::args::Render;
use crate::devices::Device;
use crate::failure::Failure;
use crate::format::{bytes, count};
use crate::input::Input;
use crate::maps;
use crate::shadow_files::Shadow;
use crate::surfaces;

/// The light that `emitters` send to surfaces. Shadows come from files where there are some, and
/// otherwise from the map of each emitter if there is anything translucent. Dynamic casters are
/// not in files, so their shadows come from maps. On a GPU the emitters with shadows from files
/// are lit there, unless something else is in the way of their light.
pub(crate) fn of_surfaces(
    args: &Render,
    input: &mut Input,
    (view, device): (&View, &Device),
    emitters: &[Emitter],
    shadows: &[Option<Shadow>],
    maps: &[&TransmittanceMap],
) -> Result<Vec<[f32; 4]>, Failure> {
    if shadows.iter().all(Option::is_none) {
        return Ok(surfaces::radiance_of(view, input, emitters, maps));
    }
    let filter = FilterSize::new(args.filter.unwrap_or(9))
        .map_err(|error| Failure::from(error).about("--filter"))?;
    let mut context = device.context.as_ref();
    if let (Some(_), Some(why)) = (context, not_on_gpus(input)) {
        (input.notes).push(format!("surfaces are lit on the CPU: {why}"));
        context = None;
    }
    let all = emitters.iter().zip(shadows);
    let (on_gpu, on_cpu): (Vec<_>, Vec<_>) =
        all.partition(|(_, shadow)| context.is_some() && shadow.is_some());
    let side = args.options.map();
    let radiance = on_the_cpu(input, view, &on_cpu, (filter, side))?;
    let Some(context) = context else {
        return Ok(radiance);
    };
    let cpu = Cpu::new();
    let gpu = Gpu::new(context.clone());
    let (scene, geometry) = (&input.scene, &input.geometry);
    let points = surface::points(&cpu, view, scene, geometry, scene.medium.as_ref());
    let points = gpu.upload(&points)?;
    let mut sums = gpu.upload(&radiance)?;
    let (emitters, shadows): (Vec<Emitter>, Vec<BakedShadow>) = on_gpu
        .into_iter()
        .filter_map(|(emitter, shadow)| Some((emitter.clone(), (**shadow.as_ref()?).clone())))
        .unzip();
    let most = context.limits().max_storage_buffer_binding_size;
    let mut rest = &emitters[..];
    for part in BakedShadows::upload_in_bindings(&shadows, &gpu)? {
        let (own, others) = rest.split_at(part.lights().len());
        rest = others;
        let biases: Vec<f32> = part.lights().iter().map(BakedShadow::bias).collect();
        let moving = dynamic_maps(&gpu, input, (own, &biases), (side, most))?;
        let filtered = part.filtered(filter);
        let lists = PointLists::of_picture(&cpu, view.rays(), view.width(), own);
        let medium = input.scene.medium.as_ref();
        let lit = LitPoints {
            lights_per_dispatch: filtered.lights_per_dispatch(),
            ..LitPoints::new(&points, own, &lists, medium)
        };
        let Some(maps) = moving else {
            gpu.add_direct_light(&lit, &filtered, &mut sums)?;
            continue;
        };
        let maps = maps.filtered(filter.width());
        let lit = LitPoints {
            // A shader that loops over both kinds of shadows takes half as many lights at once,
            // so that it stays within the limit of turns of each kind.
            lights_per_dispatch: (filtered
                .lights_per_dispatch()
                .min(maps.lights_per_dispatch())
                / 2)
            .max(1),
            ..lit
        };
        gpu.add_direct_light(&lit, &Both(filtered, maps), &mut sums)?;
    }
    Ok(gpu.download(&sums)?)
}

/// The emitters whose light is computed on the CPU.
fn on_the_cpu(
    input: &mut Input,
    view: &View,
    lights: &[(&Emitter, &Option<Shadow>)],
    (filter, side): (FilterSize, u32),
) -> Result<Vec<[f32; 4]>, Failure> {
    let cpu = Cpu::new();
    let of_files = lights.iter().filter_map(|(emitter, shadow)| {
        let shadow = shadow.as_ref()?;
        Some(((*emitter).clone(), shadow.bias()))
    });
    let (emitters, biases): (Vec<Emitter>, Vec<f32>) = of_files.unzip();
    let moving = dynamic_maps(&cpu, input, (&emitters, &biases), (side, maps::MAX_BYTES))?;
    let mut numbers = 0..;
    let shadows: Vec<Option<Box<dyn SurfaceShadow>>> = lights
        .iter()
        .map(|(_, shadow)| {
            let baked = shadow.as_ref()?.filtered(filter);
            let light = numbers.next()?;
            Some(match &moving {
                None => Box::new(baked) as _,
                Some(maps) => {
                    Box::new(Both(baked, maps.filtered(filter.width()).of_light(light))) as _
                }
            })
        })
        .collect();
    let lights: Vec<Lit<'_>> = (lights.iter().zip(&shadows))
        .map(|((emitter, _), shadow)| (*emitter, shadow.as_deref()))
        .collect();
    let (scene, geometry) = (&input.scene, &input.geometry);
    let medium = scene.medium.as_ref();
    Ok(surface::radiance_with(
        &cpu,
        view,
        scene,
        geometry,
        &input.tracer,
        &lights,
        medium,
    ))
}

/// The maps of some lights with the dynamic casters alone, of `side` texels per side or
/// as many as fit into `most` bytes, with the bias of each light's file in texels; `None` if
/// no light reaches any.
fn dynamic_maps<B: RenderShadowMap>(
    backend: &B,
    input: &mut Input,
    (emitters, biases): (&[Emitter], &[f32]),
    (side, most): (u32, u64),
) -> Result<Option<MapsOfMany<B::Memory>>, Failure> {
    let Some(dynamic) = input.geometry.dynamic_part() else {
        return Ok(None);
    };
    let casters = Casters::upload(backend, dynamic)?;
    let pictures = MapsOfMany::picture_count(&casters, emitters) as u64;
    if pictures == 0 {
        return Ok(None);
    }
    let affordable = maps::side_within(most, pictures, side);
    if affordable < side {
        input.notes.push(format!(
            "shadow maps of what is dynamic have {affordable} texels per side instead of {side}, \
             so that those of {} fit into {}",
            count(emitters.len(), "emitter"),
            bytes(most)
        ));
    }
    let maps = MapsOfMany::render(backend, &casters, emitters, affordable)?;
    Ok(Some(maps.with_biases(biases)))
}

/// Everything between lights and surfaces that shaders do not know.
fn not_on_gpus(input: &Input) -> Option<&'static str> {
    if input.geometry.coatings().any_see_through() {
        return Some("the shadows of see-through surfaces are traced");
    }
    let fog = input.scene.height_fog.is_some();
    fog.then_some("fog thins out with altitude on the way from the lights")
}
