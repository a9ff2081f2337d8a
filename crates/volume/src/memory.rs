//! Large vectors. Where the system has no memory for one, that is an error.

use crate::error::{Error, ErrorKind};
use bytemuck::Zeroable;

/// A vector with room for `count` elements.
///
/// # Errors
/// [`ErrorKind::NoMemory`].
pub(crate) fn reserved<T>(count: usize) -> Result<Vec<T>, Error> {
    let mut list = Vec::new();
    reserve(&mut list, count)?;
    Ok(list)
}

/// Makes room for exactly `additional` more elements.
///
/// # Errors
/// [`ErrorKind::NoMemory`].
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), Error> {
    list.try_reserve_exact(additional)
        .map_err(|_| no_memory::<T>(additional))
}

/// Makes room for `additional` more elements, and for more to come.
///
/// # Errors
/// [`ErrorKind::NoMemory`].
#[cfg(any(feature = "dicom", feature = "tiff"))]
pub(crate) fn grow<T>(list: &mut Vec<T>, additional: usize) -> Result<(), Error> {
    list.try_reserve(additional)
        .map_err(|_| no_memory::<T>(additional))
}

/// `count` zeros, which the system hands out without writing them.
///
/// # Errors
/// [`ErrorKind::NoMemory`].
pub(crate) fn zeroed<T: Zeroable>(count: usize) -> Result<Vec<T>, Error> {
    bytemuck::allocation::try_zeroed_vec(count).map_err(|()| no_memory::<T>(count))
}

fn no_memory<T>(count: usize) -> Error {
    ErrorKind::NoMemory {
        bytes: (count as u64).saturating_mul(size_of::<T>() as u64),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_system_has_is_an_error_with_its_number() {
        let count = isize::MAX as usize / 8;
        for error in [
            reserved::<u64>(count).unwrap_err(),
            zeroed::<u64>(count).unwrap_err(),
        ] {
            let message = error.to_string();
            assert!(
                message.contains(&(8 * count as u64).to_string()),
                "{message}"
            );
        }
        assert_eq!(zeroed::<u8>(2).unwrap(), [0, 0]);
    }
}
