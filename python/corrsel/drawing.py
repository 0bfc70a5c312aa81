"""Pictures of matches."""

from . import _arrays, _features
from .selectors import Matches, Selection


def draw(image_left, image_right, matches, selection, *, width=1600, max_lines=100, title=""):
    """Return a picture of a selection: height x width x 3, BGR, uint8, as cv2.imwrite() and cv2.imshow() take it.

    image_left, image_right   as in corrsel.match(); None = plain ground of the size that the matches state
    matches      Matches: those that the selector was given
    selection    Selection of these matches
    width        of the picture, px, to which the images are reduced or enlarged, but at most twice; 0 = they stay as
                 they are
    max_lines    largest number of lines of the kept and of the rejected matches each; their points are all drawn
    title        first line of the caption; by default, it tells what the selector found

    The images are grey. Rejected matches are thin dark lines and crosses; above them, the kept ones are lines and discs
    in the colours of their groups, which the caption below the images explains. Images that are wide and flat are put
    above each other, others side by side.

    Raises TypeError for anything but Matches and Selection and for images of another dtype; ValueError for images of
    another shape, and for a selection of another number of matches.
    """
    for name, value, kind in (("matches", matches, Matches), ("selection", selection, Selection)):
        if not isinstance(value, kind):
            raise TypeError("%s is %s; needed: corrsel.%s" % (name, type(value).__name__, kind.__name__))
    return _features.draw(
        None if image_left is None else _arrays.image("image_left", image_left),
        None if image_right is None else _arrays.image("image_right", image_right),
        matches,
        selection,
        int(width),
        int(max_lines),
        str(title),
    )
