//! Waiting for others without being out of reach.

use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;
use strahl_volume::{Cancelled, Control};

/// What is behind `mutex`, when nobody else uses it; whoever waits may be cancelled.
pub fn locked<'m, T>(
    mutex: &'m Mutex<T>,
    control: &Control,
) -> Result<MutexGuard<'m, T>, Cancelled> {
    loop {
        control.check()?;
        match mutex.try_lock() {
            Ok(guard) => return Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => return Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}
