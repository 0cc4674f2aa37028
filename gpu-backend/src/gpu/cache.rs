//! Values that are built once per device.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex};

use super::lock;
use crate::Error;

/// One map per pair of key and value type, so that crates that know nothing of
/// each other share a cache without agreeing on keys.
#[derive(Default)]
pub(super) struct Cache {
    maps: Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>,
}

/// The outer lock is held to find a slot, the slot's own while its value is
/// built: slow pipelines do not keep others waiting.
type Slot<V> = Arc<Mutex<Option<Arc<V>>>>;
type Slots<K, V> = Mutex<HashMap<K, Slot<V>>>;

impl Cache {
    pub(super) fn get<K, V>(
        &self,
        key: K,
        build: impl FnOnce() -> Result<V, Error>,
    ) -> Result<Arc<V>, Error>
    where
        K: Hash + Eq + Send + Sync + 'static,
        V: Send + Sync + 'static,
    {
        let slot = self.slot::<K, V>(key);
        let mut value = lock(&slot);
        if let Some(value) = &*value {
            return Ok(Arc::clone(value));
        }
        let built = Arc::new(build()?);
        *value = Some(Arc::clone(&built));
        Ok(built)
    }

    fn slot<K, V>(&self, key: K) -> Slot<V>
    where
        K: Hash + Eq + Send + Sync + 'static,
        V: Send + Sync + 'static,
    {
        let slots = Arc::clone(
            lock(&self.maps)
                .entry(TypeId::of::<(K, V)>())
                .or_insert_with(|| Arc::new(Slots::<K, V>::default())),
        );
        let slots = slots
            .downcast::<Slots<K, V>>()
            .expect("the map under the id of a type is of that type");
        Arc::clone(lock(&slots).entry(key).or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_built_once_per_key_and_type_and_failures_are_tried_again() {
        let cache = Cache::default();
        let fail = || Err(Error::OutOfMemory { what: "it".into() });
        assert!(cache.get::<u8, u32>(1, fail).is_err());
        assert_eq!(*cache.get(1_u8, || Ok(10_u32)).unwrap(), 10);
        assert_eq!(*cache.get(1_u8, || Ok(11_u32)).unwrap(), 10);
        assert_eq!(*cache.get(2_u8, || Ok(12_u32)).unwrap(), 12);
        assert_eq!(*cache.get(1_u8, || Ok(13_i32)).unwrap(), 13);
        assert_eq!(*cache.get(1_u16, || Ok(14_u32)).unwrap(), 14);
    }

    #[test]
    fn threads_that_ask_at_once_get_the_same_value() {
        let cache = Cache::default();
        let built = Mutex::new(0);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    cache.get(0_u8, || {
                        *lock(&built) += 1;
                        Ok(1_u8)
                    })
                });
            }
        });
        assert_eq!(*lock(&built), 1);
    }
}
