import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # the module of random parts beside the tests
