from pathlib import Path
from gyro_cosim.paper.cases import Extent
from gyro_cosim.paper import robust
import time
if __name__=="__main__":
    t=time.time()
    p=robust.survived(Path("/tmp/wt-baseline/results/rob"),1,Extent(straight=4.0,behind_slow=1.,behind_fast=1.))
    print(robust.markdown(p), time.time()-t)
