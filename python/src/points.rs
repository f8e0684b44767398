//! Points that come as columns.

use std::path::PathBuf;

use gable::run;
use gable::source::points::ScanPoint;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::exception;

/// Takes points column by column, chunk by chunk; they wait in a nameless temporary file, 32 bytes each.
#[pyclass]
pub struct Feed {
    /// Until the run takes it.
    feed: Option<run::Feed>,
}

#[pymethods]
impl Feed {
    #[new]
    fn new(py: Python<'_>, name: PathBuf) -> PyResult<Self> {
        let feed = run::Feed::new(name).map_err(|error| exception(py, &error))?;
        Ok(Self { feed: Some(feed) })
    }

    /// Takes a chunk. All columns are contiguous and of one length, the coordinates finite; flags are 1 synthetic,
    /// 4 withheld, 8 overlap, or sums of these.
    #[pyo3(signature = (x, y, z, classification, return_number=None, flags=None))]
    #[expect(clippy::too_many_arguments, reason = "one for each column")]
    fn push(
        &mut self,
        py: Python<'_>,
        x: PyReadonlyArray1<'_, f64>,
        y: PyReadonlyArray1<'_, f64>,
        z: PyReadonlyArray1<'_, f64>,
        classification: PyReadonlyArray1<'_, u8>,
        return_number: Option<PyReadonlyArray1<'_, u8>>,
        flags: Option<PyReadonlyArray1<'_, u8>>,
    ) -> PyResult<()> {
        let Some(feed) = &mut self.feed else { return Err(PyValueError::new_err("the points have been used")) };
        let (x, y, z, classes) = (x.as_slice()?, y.as_slice()?, z.as_slice()?, classification.as_slice()?);
        let returns = return_number.as_ref().map(|column| column.as_slice()).transpose()?;
        let flags = flags.as_ref().map(|column| column.as_slice()).transpose()?;
        let lengths =
            [Some(y.len()), Some(z.len()), Some(classes.len()), returns.map(<[u8]>::len), flags.map(<[u8]>::len)];
        if lengths.into_iter().flatten().any(|length| length != x.len()) {
            return Err(PyValueError::new_err("the columns differ in length"));
        }
        let has = |i: usize, bit: u8| flags.is_some_and(|flags| flags[i] & bit != 0);
        let point = |i: usize| ScanPoint {
            return_number: returns.map_or(0, |returns| returns[i]),
            synthetic: has(i, 0x01),
            withheld: has(i, 0x04),
            overlap: has(i, 0x08),
            ..ScanPoint::new([x[i], y[i], z[i]], classes[i])
        };
        feed.push((0..x.len()).map(point)).map_err(|error| exception(py, &error))
    }
}

impl Feed {
    /// The points that came, to be used once.
    pub fn take(&mut self) -> Option<run::Feed> {
        self.feed.take()
    }
}
