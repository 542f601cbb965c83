"""xMCF (ISO/PAS 8329): weld seams of other programs, read and written."""
