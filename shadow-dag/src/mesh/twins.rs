//! Surfaces that are there more than once.

use std::collections::HashMap;

use gpu_backend::Cpu;

use super::sorted::{PARTS, Parts};
use super::triangle::{Kind, Triangle};

/// Leaves out all but the first of triangles that are the same to the light, since each of
/// them would be looked at under every texel. Only what encloses nothing is left out: of
/// solids it counts how many there are.
pub(super) fn leave_out(cpu: &Cpu, triangles: &mut Vec<Triangle>) {
    let parts = Parts::new(
        cpu,
        triangles.len(),
        |number, parts: &mut [Vec<[u64; 2]>]| {
            let triangle = &triangles[number];
            if triangle.kind == Kind::Open && triangle.mask().is_none() {
                let hash = triangle.identity().value();
                parts[hash as usize % PARTS].push([hash, number as u64]);
            }
        },
    );
    let again = cpu.map(PARTS, |part| {
        let mut first = HashMap::with_capacity(parts.len(part));
        let is_again = |&&[hash, number]: &&[u64; 2]| {
            let earlier = *first.entry(hash).or_insert(number);
            earlier != number && triangles[earlier as usize] == triangles[number as usize]
        };
        let again = parts.part(part).filter(is_again);
        again
            .map(|&[_, number]| number as usize)
            .collect::<Vec<_>>()
    });
    let mut again: Vec<usize> = again.into_iter().flatten().collect();
    again.sort_unstable();
    let (mut again, mut number) = (again.into_iter().peekable(), 0..);
    triangles.retain(|_| {
        again
            .next_if_eq(&number.next().unwrap_or_default())
            .is_none()
    });
}
