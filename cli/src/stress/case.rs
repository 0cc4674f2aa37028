//! A hard picture and the methods that make it.

use std::sync::atomic::{AtomicBool, Ordering};

use gpu_backend::{Buffer, Download, Host};
use lighting::methods::{
    Entry, Frame, FrameInputs, MethodBackend, MethodError, Selection, Store, Verdict,
};
use reference::hard_cases::FrameCase;
use reference::metrics::Reference;
use reference::scenes::TestScene;

use super::check::{Finding, Outcome};
use crate::failure::Failure;

/// A picture and the truth about it.
pub(super) struct Case {
    scene: TestScene,
    truth: Reference,
    /// Whether all that fills the air is even fog.
    is_even: bool,
    map: u32,
    host: Store<Host>,
}

impl Case {
    pub(super) fn new(case: FrameCase, map: u32) -> Self {
        let scene = TestScene::of(case.name, case.scene, case.size[0], case.size[1]);
        let is_even = scene.translucent.is_empty() && scene.height_fog.is_none();
        let truth = match is_even {
            true => scene.truth(),
            false => scene.truth_in_media(),
        };
        Self {
            truth,
            is_even,
            scene,
            map,
            host: Store::new(),
        }
    }

    fn inputs(&self) -> FrameInputs<'_> {
        FrameInputs {
            emitters: &self.scene.emitters,
            areas: &self.scene.areas,
            medium: &self.scene.medium,
            height_fog: self.scene.height_fog.as_ref(),
            geometry: &self.scene.geometry,
            translucent: &self.scene.translucent,
            camera: &self.scene.camera,
            size: self.scene.size,
            rays: &self.scene.rays,
            hits: &self.scene.hits,
            map: self.map,
            host: &self.host,
            selection: Selection::default(),
            watch: &(),
        }
    }

    /// The outcome of each method that applies and runs on the backend, at the best quality of a
    /// quick comparison, until the user interrupts the program.
    pub(super) fn run<B: MethodBackend + Download>(
        &self,
        backend: &B,
        label: &str,
        entries: &[&Entry],
        stop: &AtomicBool,
    ) -> Result<Vec<Finding>, Failure> {
        let inputs = self.inputs();
        let store = Store::new();
        let mut findings = Vec::new();
        for entry in entries {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            let method = entry.method();
            let sees_all = self.is_even || method.sees_heterogeneous_media();
            let applies = sees_all && method.applies(&inputs) == Verdict::Applies;
            if entry.on::<B>().is_none() || !applies {
                continue;
            }
            let about = entry.about();
            let (qualities, _) = entry.method().distinct(&inputs, about.quick);
            let Some(&quality) = qualities.last() else {
                continue;
            };
            let outcome = match self.image(backend, &store, entry, quality) {
                Ok(image) => Outcome::of(entry, quality, &image, &self.truth),
                Err(error) => {
                    backend.check_alive()?;
                    Outcome::refused(Failure::from(error).to_string())
                }
            };
            findings.push(Finding {
                case: self.scene.name,
                method: about.name.into_owned(),
                backend: label.to_owned(),
                quality,
                outcome,
            });
        }
        Ok(findings)
    }

    fn image<B: MethodBackend + Download>(
        &self,
        backend: &B,
        store: &Store<B::Memory>,
        entry: &Entry,
        quality: u32,
    ) -> Result<Vec<[f32; 4]>, MethodError> {
        let Some(method) = entry.on::<B>() else {
            let name = entry.about().name.into_owned();
            return Err(MethodError::UnsupportedBackend { name });
        };
        let frame = Frame::new(backend, self.inputs(), store)?;
        let mut radiance = backend.zeros::<[f32; 4]>(frame.rays.len())?;
        method.prepare(&frame, quality)?;
        method.add_radiance(&frame, quality, &mut radiance)?;
        Ok(backend.download(&radiance)?)
    }
}
