"""What the doors to other libraries share: which selections they accept, and arrays of numpy or tensors of torch."""

import numpy as np

#: Statuses of a Selection that is a result.
_RESULTS = ("ok", "time_limit")


def kept(selection):
    """Return the mask of a Selection: N, bool. Nothing is kept unless the selector is sure of its result."""
    return selection.mask if selection.status in _RESULTS else np.zeros_like(selection.mask)


def to_numpy(values):
    """Return a tensor of torch, on any device and of any type, or anything else that numpy takes, as an array."""
    if hasattr(values, "detach"):
        values = values.detach().cpu()
        if values.is_floating_point():
            values = values.float()  # numpy has no bfloat16
        return values.numpy()
    return np.asarray(values)


def to_floats(values):
    """Return numbers of any type as an array of float32."""
    return to_numpy(values).astype(np.float32, copy=False)


def like(example, array):
    """Return an array as what `example` is: as a tensor on the same device if it is one. The type is that of `example`
    where both hold whole or both hold real numbers, otherwise int64 or float32."""
    real = array.dtype.kind == "f"
    if hasattr(example, "new_tensor"):
        if example.is_floating_point() != real:
            example = example.new_tensor([])
            example = example.float() if real else example.long()
        return example.new_tensor(array)
    dtype = np.asarray(example).dtype
    if (dtype.kind == "f") != real:
        dtype = np.float32 if real else np.int64
    return np.ascontiguousarray(array, dtype)
