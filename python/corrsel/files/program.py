"""What the programs of this package have in common."""
import sys

from .pairs import InputError


def run(parser, work, arguments):
    """Print what work(parsed arguments) returns, or its InputError; return the exit status: 0 or 2."""
    parsed = parser.parse_args(arguments)
    try:
        print(work(parsed))
    except InputError as error:
        print("%s: %s" % (parser.prog, error), file=sys.stderr)
        return 2
    return 0
