//! Area lights as many virtual lights, made anew in every frame from shadow maps
//! that are kept.

use std::sync::{Arc, Mutex, PoisonError};

use gpu_backend::{Backend, Buffer, BufferOf, Memory};
use voxel_shadow::BuildAtlas;

use super::{BuildLightVolumes, GatherMany, LightVolumes, ManyLights};
use crate::Emitter;
use crate::airlight::EquiAngular;
use crate::methods::evaluators::Gauss;
use crate::methods::reduced::{Reduced, Reduction, ShownAs};
use crate::methods::{
    About, Entry, Evaluators, Frame, FrameInputs, Method, MethodError, OfScene, Role, RunOn,
    Verdict, Work,
};
use crate::scene::Pattern;
use crate::shadow_map::{
    CasterPoints, LevelOfDetail, RenderImperfectMaps, RenderShadowMapAtlas, ShadowMapAtlas,
};
use crate::voxelized::{Detail, Eye, Resolution};

const UNIT: &str = "points per area light";

/// Points per area light, at most.
const MOST: u32 = 4096;

/// Texels a side of shadow maps, and voxels along each axis, at most: what the
/// paper found enough for many lights.
const SIDE: u32 = 128;

/// Points that stand for the casters in imperfect shadow maps, and how many of them
/// each light takes.
const CASTER_POINTS: u32 = 1 << 16;
const POINTS_PER_MAP: u32 = 4096;

/// How the shadow maps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Maps {
    /// From triangles.
    Exact,
    /// From points.
    Imperfect,
}

/// Voxels that are gathered in some detail.
#[derive(Debug, Clone, Copy)]
struct AreaLights {
    name: &'static str,
    title: &'static str,
    purpose: &'static str,
    paper: &'static str,
    role: Role,
    maps: Maps,
    detail: Detail,
    nodes: u32,
}

/// The virtual lights of a frame and their shadow maps, in groups whose maps and
/// voxels fit on the backend.
#[derive(Debug)]
struct Groups<M: Memory>(Vec<(Vec<Emitter>, ShadowMapAtlas<M>)>);

/// What the groups of a scene are known by: points per area light, and how their maps
/// are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfAreas {
    points: u32,
    maps: Maps,
}

/// Voxels that are kept from frame to frame, which all groups use in turn.
#[derive(Debug)]
struct Kept<M: Memory>(Mutex<Option<LightVolumes<M>>>);

/// What the voxels of so many lights are known by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfLights(usize);

/// The lights of a frame, area lights as so many points each; others as they are.
fn virtual_lights(inputs: &FrameInputs<'_>, points: u32) -> Result<Vec<Emitter>, MethodError> {
    if !(1..=MOST).contains(&points) {
        return Err(MethodError::Quality {
            value: points,
            unit: UNIT,
            expected: format!("1 to {MOST}"),
        });
    }
    let mut lights = Vec::new();
    let mut next = 0;
    for area in inputs.areas {
        let range = &area.emitters;
        lights.extend_from_slice(inputs.emitters.get(next..range.start).unwrap_or_default());
        let own = area.light.virtual_lights(Pattern::Lattice, points);
        lights.extend(own.map_err(MethodError::resource("virtual lights"))?);
        next = range.end;
    }
    lights.extend_from_slice(inputs.emitters.get(next..).unwrap_or_default());
    Ok(lights)
}

fn resolution() -> Result<Resolution, MethodError> {
    Resolution::new(SIDE, SIDE, SIDE).map_err(MethodError::resource("voxels of many lights"))
}

impl<M: Memory> Groups<M> {
    /// Groups of at most so many lights.
    fn make<B>(frame: &Frame<'_, B>, key: OfAreas, most: usize) -> Result<Self, MethodError>
    where
        B: RenderShadowMapAtlas + RenderImperfectMaps + Backend<Memory = M>,
    {
        let backend = frame.backend;
        let all = virtual_lights(&frame.inputs, key.points)?;
        let mut groups = Vec::new();
        for lights in all.chunks(most.max(1)) {
            let (done, total) = (groups.len() * most, all.len());
            if !frame.inputs.watch.goes_on(done, total) {
                return Err(MethodError::Stopped { done, total });
            }
            let maps = match key.maps {
                Maps::Exact => backend.shadow_map_atlas(&*frame.casters()?, lights, SIDE),
                Maps::Imperfect => {
                    let casters = caster_points(frame)?;
                    let level = LevelOfDetail::Near;
                    backend.imperfect_maps(&casters, lights, SIDE, POINTS_PER_MAP, level)
                }
            };
            let maps = maps.map_err(MethodError::resource("the shadow maps of many lights"))?;
            groups.push((lights.to_vec(), maps));
        }
        Ok(Self(groups))
    }

    /// The lights of the largest group: only the last one may have fewer.
    fn lights(&self) -> usize {
        self.0.first().map_or(0, |(lights, _)| lights.len())
    }

    fn of<B>(frame: &Frame<'_, B>, points: u32, maps: Maps) -> Result<Arc<Self>, MethodError>
    where
        B: RenderShadowMapAtlas + RenderImperfectMaps + BuildAtlas + Backend<Memory = M>,
    {
        let key = OfAreas { points, maps };
        let bytes = |all: &Self| all.0.iter().map(|(_, maps)| maps.bytes()).sum();
        let what = "shadow maps of virtual lights";
        frame.store.get(what, key, bytes, || {
            let voxels = frame.backend.atlas_capacity(resolution()?);
            let cubes = frame.backend.map_capacity(SIDE);
            let lights = match maps {
                Maps::Exact => cubes,
                // A picture instead of six.
                Maps::Imperfect => cubes.saturating_mul(6),
            };
            Self::make(frame, key, voxels.min(lights))
        })
    }
}

/// The points that stand for the casters.
fn caster_points<B: Backend>(
    frame: &Frame<'_, B>,
) -> Result<Arc<CasterPoints<B::Memory>>, MethodError> {
    let bytes = |points: &CasterPoints<B::Memory>| 16 * points.points().len() as u64;
    frame.store.get("points of casters", OfScene, bytes, || {
        let points = CasterPoints::sample(frame.backend, frame.inputs.geometry, CASTER_POINTS);
        Ok(points?)
    })
}

impl Method for AreaLights {
    fn about(&self) -> About {
        About {
            name: self.name.into(),
            title: self.title,
            purpose: self.purpose,
            paper: self.paper,
            quality: UNIT,
            qualities: &[16, 64, 256, 1024],
            quick: &[16, 64],
            pictured: 256,
            usual: 256,
            role: self.role,
            // Its maps have a size of their own.
            uses_shadow_map: false,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if inputs.areas.is_empty() {
            return Verdict::Impossible("no light has an area".into());
        }
        if !inputs.translucent.is_empty() {
            return Verdict::Pointless("it does not see hair and smoke".into());
        }
        if inputs.geometry.coatings().any_see_through() {
            return Verdict::Pointless("it does not see what is see-through".into());
        }
        Verdict::Applies
    }

    /// By the lights of each group.
    fn interleaves(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        if !inputs.translucent.is_empty() {
            notes.push(format!("hair and smoke cast no shadow with {}", self.name));
        }
        if inputs.geometry.coatings().any_see_through() {
            notes.push(format!(
                "see-through surfaces neither shade the air nor dim what is behind them with {}",
                self.name
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, points: u32) -> Work {
        let spread: usize = inputs.areas.iter().map(|area| area.emitters.len()).sum();
        let others = inputs.emitters.len().saturating_sub(spread);
        let lights = others as f64 + inputs.areas.len() as f64 * f64::from(points);
        let side = f64::from(SIDE);
        // At most five faces of a cube see the light.
        let (pictures, casters) = match self.maps {
            Maps::Exact => (5.0, 5.0 * inputs.geometry.triangles().len() as f64),
            Maps::Imperfect => (1.0, f64::from(POINTS_PER_MAP)),
        };
        let texels = pictures * lights * side.powi(2);
        Work {
            once: texels + lights * casters,
            // A lookup for each light ray, and a bit for each voxel, 32 at once.
            per_frame: lights * (side.powi(2) + side.powi(3) / 32.0),
            per_ray: lights * (side / 32.0 + f64::from(self.nodes)),
            bytes: (4.0 * texels + lights * (side.powi(3) / 8.0 + 4.0 * side.powi(2))) as u64,
        }
    }
}

impl<B> RunOn<B> for AreaLights
where
    B: RenderShadowMapAtlas + RenderImperfectMaps + BuildLightVolumes + GatherMany<EquiAngular>,
{
    fn prepare(&self, frame: &Frame<'_, B>, points: u32) -> Result<(), MethodError> {
        Gauss.kept(frame, self.nodes)?;
        Groups::of(frame, points, self.maps).map(|_| ())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        points: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let FrameInputs {
            medium,
            camera,
            size,
            rays,
            selection,
            watch,
            ..
        } = frame.inputs;
        let airlight = Gauss.kept(frame, self.nodes)?;
        let all = Groups::of(frame, points, self.maps)?;
        let eye = Eye::of_camera(camera, size, rays, medium);
        let new = || {
            LightVolumes::new(frame.backend, resolution()?, all.lights())
                .map_err(MethodError::resource("voxels of many lights"))
        };
        let what = "voxels of many lights";
        let bytes = |kept: &Kept<B::Memory>| {
            let kept = kept.0.lock().unwrap_or_else(PoisonError::into_inner);
            kept.as_ref().map_or(0, LightVolumes::bytes)
        };
        let kept = frame.store.get(what, OfLights(all.lights()), bytes, || {
            Ok(Kept(Mutex::new(Some(new()?))))
        })?;
        let taken = kept.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut volumes = taken.map_or_else(new, Ok)?;
        for (emitters, maps) in &all.0 {
            frame.pass("voxels", || {
                volumes
                    .update(frame.backend, emitters, &eye, maps)
                    .map_err(MethodError::resource(what))
            })?;
            let lights = ManyLights {
                rays: &frame.rays,
                emitters,
                medium,
                detail: self.detail,
                interleaving: selection.interleaving,
            };
            frame.pass("gather", || {
                Ok((frame.backend).gather_many(&lights, &volumes, &*airlight, radiance)?)
            })?;
        }
        watch.gathered(rays.len() * frame.inputs.emitters.len());
        // Its memory is used again in the order of the commands.
        *kept.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(volumes);
        Ok(())
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let bits = "Wyman and Dai, HPG 2013, for the bits";
    let imperfect = AreaLights {
        name: "area-imperfect",
        title: "imperfect voxelized shadow volumes",
        purpose: "soft shadows of area lights at a cost that triangles do not raise; \
            its error has a floor",
        paper: "Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013",
        role: Role::Paper,
        maps: Maps::Imperfect,
        detail: Detail::Average,
        nodes: 8,
    };
    let runs = AreaLights {
        name: "area-runs",
        title: "area lights by many shadow volumes, lit runs",
        purpose: "the same bits by runs: soft shadows of area lights that converge",
        paper: bits,
        role: Role::Variant,
        maps: Maps::Exact,
        detail: Detail::Runs,
        nodes: 4,
    };
    let reduced = |name, title, purpose| ShownAs {
        name,
        title,
        purpose,
        paper: "Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section 3.4",
        qualities: &[64, 256],
        quick: &[64],
        pictured: 256,
    };
    vec![
        Entry::everywhere(imperfect),
        Entry::everywhere(AreaLights {
            name: "area-average",
            title: "area lights by many shadow volumes, averaged",
            purpose: "the same with exact shadow maps: the floor of the average alone",
            paper: bits,
            role: Role::Variant,
            maps: Maps::Exact,
            detail: Detail::Average,
            nodes: 8,
        }),
        Entry::everywhere(AreaLights {
            name: "area-voxels",
            title: "area lights by many shadow volumes, per voxel",
            purpose: "the same bits with a weight each: no floor but that of the voxels",
            paper: "Wyman and Dai, HPG 2013: the weighted average that they mention",
            role: Role::Variant,
            maps: Maps::Exact,
            detail: Detail::Voxels,
            nodes: 1,
        }),
        Entry::everywhere(runs),
        Entry::everywhere(
            Reduced::new(runs, Reduction::WINDOWS_OF_3).shown_as(reduced(
                "area-runs 3x3",
                "area lights by many shadow volumes, 3 x 3 interleaved",
                "many points: a ninth of them at each pixel, put together over its neighbours",
            )),
        ),
        Entry::everywhere(
            Reduced::new(runs, Reduction::WINDOWS_OF_3.and_a_quarter()).shown_as(reduced(
                "area-runs 3x3 quarter",
                "area lights by many shadow volumes, 3 x 3, quarter",
                "a ninth of the points at a quarter of the pixels: the least work for soft light",
            )),
        ),
        // The paper's own, and what its parts are worth, for those who ask.
        Entry::everywhere(Reduced::new(runs, Reduction::QUARTER)),
        Entry::everywhere(Reduced::new(imperfect, Reduction::WINDOWS_OF_3)),
        Entry::everywhere(Reduced::new(imperfect, Reduction::QUARTER)),
    ]
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gpu_backend::{Cpu, Host};

    use super::*;
    use crate::Interleaving;
    use crate::methods::area::tests::{SIZE, camera, fog, geometry, panel, rays};
    use crate::methods::{Selection, Store};
    use crate::scene::{AreaEmitters, Emission, Medium};

    /// A frame with a lamp, the panel and another lamp.
    fn with_frame(test: impl FnOnce(&Frame<'_, Cpu>)) {
        let lamp = |x: f32| {
            let position = Vec3::new(x, 3.0, -4.0);
            Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
        };
        let mut emitters = vec![lamp(-2.0)];
        emitters.extend(panel().virtual_lights(Pattern::Lattice, 4).unwrap());
        emitters.push(lamp(2.0));
        let areas = [AreaEmitters {
            light: panel(),
            emitters: 1..5,
        }];
        let (cpu, host, store) = (Cpu::new(), Store::<Host>::new(), Store::<Host>::new());
        let (geometry, medium, rays): (_, Medium, _) = (geometry(), fog(), rays());
        let hits = vec![None; rays.len()];
        let inputs = FrameInputs {
            emitters: &emitters,
            areas: &areas,
            medium: &medium,
            geometry: &geometry,
            translucent: &[],
            camera: &camera(),
            size: SIZE,
            rays: &rays,
            hits: &hits,
            map: 32,
            host: &host,
            selection: Selection::default(),
            watch: &(),
        };
        test(&Frame::new(&cpu, inputs, &store).unwrap());
    }

    #[test]
    fn area_lights_are_points_in_the_place_of_their_emitters() {
        with_frame(|frame| {
            let lights = virtual_lights(&frame.inputs, 9).unwrap();
            assert_eq!(lights.len(), 11);
            assert_eq!(lights[0], frame.inputs.emitters[0]);
            assert_eq!(lights[10], frame.inputs.emitters[5]);
            let sum = |all: &[Emitter]| all.iter().map(Emitter::intensity).sum::<Vec3>();
            let [few, more] = [sum(frame.inputs.emitters), sum(&lights)];
            assert!((few / more - 1.0).length() < 1e-5);
            for points in [0, MOST + 1] {
                let error = virtual_lights(&frame.inputs, points).unwrap_err();
                assert!(error.to_string().contains("1 to 4096"), "{error}");
            }
            let without = FrameInputs {
                areas: &[],
                ..frame.inputs
            };
            assert_eq!(virtual_lights(&without, 9).unwrap(), frame.inputs.emitters);
        });
    }

    /// One ray ten times, of which nine share the lights.
    #[test]
    fn rays_that_share_the_lights_have_all_of_them_together() {
        with_frame(|frame| {
            let inputs = FrameInputs {
                rays: &[frame.inputs.rays[100]; 10],
                hits: &[None; 10],
                selection: Selection {
                    pixels: Some(&[100; 10]),
                    interleaving: Interleaving::new(9, 1),
                },
                ..frame.inputs
            };
            let store = Store::<Host>::new();
            let frame = Frame::new(frame.backend, inputs, &store).unwrap();
            for entry in methods() {
                let mut radiance = vec![[0.0; 4]; 10];
                let method = entry.on::<Cpu>().unwrap();
                method.add_radiance(&frame, 9, &mut radiance).unwrap();
                let mean = radiance[..9].iter().map(|pixel| pixel[0]).sum::<f32>() / 9.0;
                let all = radiance[9][0];
                assert!(all > 0.0 && (mean / all - 1.0).abs() < 1e-5, "{mean} {all}");
                assert!(radiance[..9].iter().any(|pixel| pixel[0] != all));
            }
        });
    }

    #[test]
    fn groups_of_any_size_are_the_same_lights_and_the_same_image() {
        with_frame(|frame| {
            let key = |maps| OfAreas { points: 9, maps };
            for maps in [Maps::Exact, Maps::Imperfect] {
                let image = |most: usize| {
                    let groups = Groups::make(frame, key(maps), most).unwrap();
                    assert_eq!(groups.0.len(), 11_usize.div_ceil(most));
                    let store = Store::<Host>::new();
                    let frame = Frame::new(frame.backend, frame.inputs, &store).unwrap();
                    let own = key(maps);
                    store.insert("groups", own, Arc::new(groups), 0);
                    let method = AreaLights {
                        name: "test",
                        title: "test",
                        purpose: "",
                        paper: "",
                        role: Role::Variant,
                        maps,
                        detail: Detail::Runs,
                        nodes: 2,
                    };
                    let mut radiance = vec![[0.0; 4]; frame.inputs.rays.len()];
                    method.add_radiance(&frame, 9, &mut radiance).unwrap();
                    radiance
                };
                let whole = image(100);
                assert!(whole.iter().any(|pixel| pixel[0] > 0.0));
                assert_eq!(image(4), whole);
                assert_eq!(image(1), whole);
            }
        });
    }
}
