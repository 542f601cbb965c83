"""What was observed: points, touches and bodies, what each lies on, and the problems that every criterion fits."""
