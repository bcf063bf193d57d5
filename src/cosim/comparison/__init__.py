"""Is one component as good as another? Differences, tolerances, frequency responses, energy at its bonds. Do verdicts survive?"""
