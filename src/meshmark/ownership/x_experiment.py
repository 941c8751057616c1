import os
g=lambda n,d: float(os.environ.get("MM_"+n,d))
TOLD=g("TOLD",.76); RATIO=g("RATIO",.8); NEAR=g("NEAR",.5); MU=g("MU",.1)
DECAY=g("DECAY",4); POWER=g("POWER",1); PITCH=g("PITCH",.4); SAY=g("SAY",0); GOAL=g("GOAL",300)
MASK=g("MASK",2)
SHARE=g("SHARE",.02); ROUNDS=g("ROUNDS",12)
PILOTS=g("PILOTS",.2); DOUBLED=g("DOUBLED",.35); NET=g("NET",0); CAND=int(g("CAND",2))
BUMP=int(g("BUMP",0))
