//! Which vertices are at the same position.

use std::hash::{BuildHasher, RandomState};
use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use gpu_backend::Cpu;

use super::sorted::{PARTS, Parts};
use crate::pool::fold;

/// Bits that are equal where coordinates are: there are two zeros.
fn key(position: Vec3) -> [u32; 3] {
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// A hash with a random key, so that no choice of positions can make it slow.
#[derive(Debug)]
struct Salt([u64; 2]);

impl Salt {
    fn new() -> Self {
        let state = RandomState::new();
        Self([0_u8, 1].map(|number| state.hash_one(number)))
    }

    fn hash(&self, [x, y, z]: [u32; 3]) -> u64 {
        let first = fold(
            (u64::from(x) | u64::from(y) << 32) ^ self.0[0],
            u64::from(z) ^ self.0[1],
        );
        fold(first ^ self.0[1], self.0[0] | 1)
    }
}

/// The part of a hash that the slots of a table do not depend on.
fn part(hash: u64) -> usize {
    (hash >> 32) as usize % PARTS
}

/// A slot of a table without a vertex.
const FREE: u32 = u32::MAX;

/// For each vertex the first one at the same position.
pub(super) fn first_at(cpu: &Cpu, positions: &[Vec3]) -> Vec<AtomicU32> {
    let salt = Salt::new();
    // The number of points that an index can name, but for the last.
    let named = positions.len().min(FREE as usize);
    let parts = Parts::new(cpu, named, |vertex, parts: &mut [Vec<u32>]| {
        parts[part(salt.hash(key(positions[vertex])))].push(vertex as u32);
    });
    let first = cpu.map(positions.len(), |vertex| AtomicU32::new(vertex as u32));
    cpu.map(PARTS, |part| {
        // Open addressing, at most half full.
        let mut slots = vec![FREE; (2 * parts.len(part)).next_power_of_two()];
        let mask = slots.len() - 1;
        for &vertex in parts.part(part) {
            let found = key(positions[vertex as usize]);
            let mut at = salt.hash(found) as usize & mask;
            loop {
                match slots[at] {
                    FREE => {
                        slots[at] = vertex;
                        break;
                    }
                    other if key(positions[other as usize]) == found => {
                        first[vertex as usize].store(other, Ordering::Relaxed);
                        break;
                    }
                    _ => at = (at + 1) & mask,
                }
            }
        }
    });
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(reference::property::cases(64))]

        #[test]
        fn the_first_vertex_at_a_position_stands_for_all(
            positions in proptest::collection::vec(
                proptest::array::uniform3(prop_oneof![Just(0.0_f32), Just(-0.0), Just(1.0), Just(1e-40)]),
                0..200,
            ),
        ) {
            let points: Vec<Vec3> = positions.iter().map(|position| Vec3::from(*position)).collect();
            let expected: Vec<u32> = points
                .iter()
                .map(|point| points.iter().position(|other| other == point).unwrap() as u32)
                .collect();
            for cpu in [Cpu::new(), Cpu::single_threaded()] {
                let found = first_at(&cpu, &points);
                let found: Vec<u32> = found.into_iter().map(AtomicU32::into_inner).collect();
                prop_assert_eq!(&found, &expected);
            }
        }
    }
}
