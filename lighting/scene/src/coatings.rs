//! What all triangles of a scene do to light.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Vec2, Vec4};

use super::caster::{Caster, Coat, Corners};
use super::{Mesh, Scene};

/// What the triangles of a [`Geometry`](crate::Geometry) do to light, by their
/// index there. Copies share their memory.
#[derive(Debug, Clone, Default)]
pub struct Coatings(Arc<List>);

#[derive(Debug, Default)]
struct List {
    coats: Vec<Coat>,
    /// The coat and the corners of each triangle that is not solid.
    coated: Vec<(u32, Corners)>,
    /// An index into `coated` or [`SOLID`] for each triangle; empty if all of
    /// them are solid.
    kinds: Vec<u32>,
    /// Whether each triangle casts no shadow; empty if all of them do.
    absent: Vec<bool>,
    /// Whether any triangle is see-through.
    is_see_through: bool,
    /// Whether some see-through triangle colours the light of lamps.
    is_coloured: bool,
}

const SOLID: u32 = u32::MAX;

impl Coatings {
    /// What a triangle does to the light of a lamp that meets it; solid for an
    /// index that no triangle has.
    #[inline]
    pub fn caster(&self, triangle: usize) -> Caster<'_> {
        if self.0.absent.get(triangle) == Some(&true) {
            return Caster::Absent;
        }
        self.cover(triangle)
    }

    /// What a triangle does to light from behind on its way to the eye. It is the same, but
    /// never [`Caster::Absent`], because a triangle that casts no shadow can still be seen.
    #[inline]
    pub fn cover(&self, triangle: usize) -> Caster<'_> {
        match self.0.kinds.get(triangle) {
            None | Some(&SOLID) => Caster::Solid,
            Some(&index) => {
                let (coat, corners) = &self.0.coated[index as usize];
                self.0.coats[*coat as usize].on(corners)
            }
        }
    }

    /// True if each triangle is [`Caster::Solid`].
    pub fn all_solid(&self) -> bool {
        self.0.kinds.is_empty() && self.0.absent.is_empty()
    }

    /// True if some triangle is [`Caster::SeeThrough`] to a lamp and lets a share of
    /// its light through that is not the same in all colour channels.
    pub fn any_coloured(&self) -> bool {
        self.0.is_coloured
    }

    /// True if some triangle is [`Caster::SeeThrough`] to the eye, whether it
    /// casts a shadow or not.
    pub fn any_see_through(&self) -> bool {
        self.0.is_see_through
    }
}

/// Collects [`Coatings`], triangle by triangle.
pub(crate) struct CoatingsOf<'a> {
    scene: &'a Scene,
    list: List,
    /// The coat of each material, with and without each of its textures; `None` if
    /// it is opaque.
    known: BTreeMap<(usize, [bool; 2]), Option<u32>>,
    /// Triangles so far.
    count: usize,
}

impl<'a> CoatingsOf<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            list: List::default(),
            known: BTreeMap::new(),
            count: 0,
        }
    }

    pub(crate) fn coat(&mut self, mesh: &Mesh) -> Option<u32> {
        let material = mesh.material?;
        let has_coordinates = [&mesh.texture_coordinates, &mesh.transmission_coordinates]
            .map(|coordinates| !coordinates.is_empty());
        if let Some(known) = self.known.get(&(material, has_coordinates)) {
            return *known;
        }
        let of = &self.scene.materials[material];
        let coat = Coat::new(of).map(|mut coat| {
            if has_coordinates[0] {
                coat = coat.with_texture(of);
            }
            if has_coordinates[1] {
                coat = coat.with_transmission_texture(of);
            }
            self.list.coats.push(coat);
            self.list.coats.len() as u32 - 1
        });
        self.known.insert((material, has_coordinates), coat);
        coat
    }

    pub(crate) fn push(
        &mut self,
        mesh: &Mesh,
        corners: [u32; 3],
        coat: Option<u32>,
        no_shadow: bool,
    ) {
        let list = &mut self.list;
        let kind = coat.map_or(SOLID, |coat| {
            let [coordinates, transmission] =
                [&mesh.texture_coordinates, &mesh.transmission_coordinates].map(|all| {
                    match all.as_slice() {
                        [] => [Vec2::ZERO; 3],
                        all => corners.map(|corner| all[corner as usize]),
                    }
                });
            let colors = match mesh.colors.as_slice() {
                [] => [Vec4::ONE; 3],
                colors => corners.map(|corner| colors[corner as usize]),
            };
            let corners = Corners {
                coordinates,
                transmission,
                colors,
            };
            if list.coats[coat as usize].is_solid(&corners) {
                return SOLID;
            }
            let caster = list.coats[coat as usize].on(&corners);
            if let Caster::SeeThrough(coating) = caster {
                list.is_see_through = true;
                list.is_coloured |= !no_shadow && !coating.is_grey();
            }
            list.coated.push((coat, corners));
            list.coated.len() as u32 - 1
        });
        // A list is begun with the first triangle that differs from the usual value.
        extend(&mut list.kinds, self.count, SOLID, kind);
        extend(&mut list.absent, self.count, false, no_shadow);
        self.count += 1;
    }

    pub(crate) fn finish(self) -> Coatings {
        Coatings(Arc::new(self.list))
    }
}

/// Appends `value`; a list of `usual` values alone stays empty.
fn extend<T: Copy + PartialEq>(list: &mut Vec<T>, count: usize, usual: T, value: T) {
    if list.is_empty() && value != usual {
        *list = vec![usual; count];
    }
    if !list.is_empty() || value != usual {
        list.push(value);
    }
}
