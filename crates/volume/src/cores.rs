//! Work on all cores, or in a row in builds without threads.

/// Has `work` done on all `items`, on the cores of the surrounding pool (feature `threads`) or one after the other. Who
/// works has something of its own, which `own` makes. Items may differ by far in what they cost: each is handed out alone.
///
/// # Errors
/// One of those that `work` gave; items that nobody has begun are then left out.
pub fn try_for_each<T: Send, L, E: Send>(
    items: impl IntoIterator<Item = T>,
    own: impl Fn() -> L + Send + Sync,
    work: impl Fn(&mut L, T) -> Result<(), E> + Send + Sync,
) -> Result<(), E> {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        let items: Vec<T> = items.into_iter().collect();
        items
            .into_par_iter()
            .with_max_len(1)
            .try_for_each_init(own, work)
    }
    #[cfg(not(feature = "threads"))]
    {
        let mut own = own();
        items.into_iter().try_for_each(|item| work(&mut own, item))
    }
}

/// Has `work` done on all `items` in the same way, where nothing can go wrong.
pub fn for_each<T: Send>(items: impl IntoIterator<Item = T>, work: impl Fn(T) + Send + Sync) {
    let Ok(()) = try_for_each(
        items,
        || (),
        |(), item| {
            work(item);
            Ok::<_, std::convert::Infallible>(())
        },
    );
}

/// What `work` makes of the numbers below `number`, in their order.
pub fn map<R: Send>(number: usize, work: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        (0..number).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "threads"))]
    (0..number).map(work).collect()
}

/// How many work at a time.
pub fn number() -> usize {
    #[cfg(feature = "threads")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "threads"))]
    1
}

/// Bytes that are given back at once.
#[cfg(feature = "threads")]
const FREED_AT_ONCE: usize = 4 << 20;

/// Gives up `values` without waiting until they are gone: the system takes back a GiB in a tenth of a second, which is too
/// long for whoever has just cancelled. They go in small parts, from the end: as long as one goes, nobody else in the process
/// gets memory from the system or gives some back.
pub fn free<T: Send + 'static>(values: Vec<T>) {
    #[cfg(feature = "threads")]
    {
        let mut values = values;
        // Where there is no thread, they go here.
        let thread = std::thread::Builder::new().name("strahl-free".to_owned());
        let _ = thread.spawn(move || {
            let part = FREED_AT_ONCE / size_of::<T>().max(1);
            while values.len() > part {
                values.truncate(values.len() - part);
                values.shrink_to_fit();
            }
        });
    }
    #[cfg(not(feature = "threads"))]
    drop(values);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn every_item_is_done_once_and_an_error_is_told() {
        let done = Mutex::new(Vec::new());
        for_each(0..100, |i| done.lock().unwrap().push(i));
        let mut done = done.into_inner().unwrap();
        done.sort_unstable();
        assert_eq!(done, map(100, |i| i));
        let failed = try_for_each(0..100, || (), |(), i| if i == 42 { Err(i) } else { Ok(()) });
        assert_eq!(failed, Err(42));
        assert!(number() >= 1);
    }
}
